//! A library between the program and the Vulkan loader: functions of a driver that a test sees or answers by itself.

use std::path::PathBuf;

use super::{Project, shared_library};

/// Includes and types.
const HEAD: &str = r"
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
typedef void (*Function)(void);
typedef Function (*Find)(void *, const char *);
";

/// The loader's own ways to its functions, and the way to the loader, which `ash` opens by this name.
const TAIL: &str = r#"
static void *vulkan;
static Find find_of_device;
static Function of_device(void *device, const char *name);
static Function answered(const char *name, Function found) {
    if (!found) return found;
    if (strcmp(name, "vkGetDeviceProcAddr")) return ours(name, found);
    find_of_device = (Find)found;
    return (Function)of_device;
}
static Function of_device(void *device, const char *name) { return answered(name, find_of_device(device, name)); }
Function vkGetInstanceProcAddr(void *instance, const char *name) {
    return answered(name, ((Find)dlsym(vulkan, "vkGetInstanceProcAddr"))(instance, name));
}
void *dlopen(const char *name, int flags) {
    void *(*open)(const char *, int) = dlsym(RTLD_NEXT, "dlopen");
    if (!name || strcmp(name, "libvulkan.so.1")) return open(name, flags);
    vulkan = open(name, flags);
    return vulkan ? open(getenv("LD_PRELOAD"), flags) : NULL;
}
"#;

/// A library for `LD_PRELOAD`. `ours` is C with `static Function ours(const char *name, Function found)`, which returns the function to call in
/// place of the found one.
pub fn before_vulkan(project: &Project, ours: &str) -> PathBuf {
    shared_library(project, "libbefore.so", &[HEAD, ours, TAIL].concat())
}
