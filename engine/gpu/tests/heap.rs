//! In a process of its own, because the test measures the process.

#![cfg(all(target_os = "linux", target_env = "gnu"))]

/// Memory of this process in MiB, resident or swapped out.
fn held() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux has it");
    let kibibytes = |name: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(name)).expect("it says so");
        line.trim().trim_end_matches(" kB").parse::<usize>().expect("a number of KiB")
    };
    (kibibytes("RssAnon:") + kibibytes("VmSwap:")) / 1024
}

#[test]
fn pages_between_what_is_kept_go_back() {
    let mut blocks: Vec<Option<Box<[u8]>>> = (0..32_768).map(|_| Some(vec![1; 4096].into_boxed_slice())).collect();
    for (index, block) in blocks.iter_mut().enumerate() {
        if index % 64 != 63 {
            *block = None;
        }
    }
    let freed = held();
    assert!(freed > 100, "{freed} MiB: what is freed between what is kept stays held");
    raxel_gpu::trim_heaps();
    let trimmed = held();
    assert!(trimmed < freed - 80, "{freed} MiB, {trimmed} MiB");
    assert!(blocks.iter().flatten().all(|block| block.iter().all(|byte| *byte == 1)), "what is kept is untouched");
}
