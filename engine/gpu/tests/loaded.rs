//! Drivers stay loaded after the last device is gone: each load may take something that its end does not give back.
#![cfg(target_os = "linux")]

use std::collections::BTreeSet;

use raxel_gpu::{Device, DeviceOptions};

/// The libraries that this process has loaded.
fn libraries() -> BTreeSet<String> {
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap_or_default();
    let paths = maps.lines().filter_map(|line| line.split_once('/').map(|(_, path)| format!("/{path}")));
    paths.filter(|path| path.contains(".so")).collect()
}

#[test]
fn drivers_stay_loaded_after_the_last_device_is_gone() {
    let before = libraries();
    let device = Device::with_cache(&DeviceOptions::default(), None).unwrap_or_else(|error| panic!("{error}"));
    let with_device = libraries();
    assert!(with_device.len() > before.len(), "the driver is a library");
    drop(device);
    let after = libraries();
    let gone: Vec<_> = with_device.difference(&after).collect();
    assert!(gone.is_empty(), "unloaded: {gone:?}");
}
