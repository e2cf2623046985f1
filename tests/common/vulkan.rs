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
const TAIL: &str = include_str!("before_vulkan.c");

/// A library for `LD_PRELOAD`. `ours` is C with `static Function ours(const char *name, Function found)`, which returns the function to call in
/// place of the found one.
pub(crate) fn before_vulkan(project: &Project, ours: &str) -> PathBuf {
    shared_library(project, "libbefore.so", &[HEAD, ours, TAIL].concat())
}
