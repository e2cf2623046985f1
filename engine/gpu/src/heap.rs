//! Memory that the process has freed and the C library still holds.

/// Gives free pages of the heaps back to the system. Drivers compile on the heaps of the C library, and the memory that they keep lies
/// scattered among the memory that they free. By itself, glibc returns only the end of a heap. Takes some milliseconds; does nothing with
/// another C library.
pub fn trim_heaps() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        unsafe extern "C" {
            fn malloc_trim(pad: usize) -> std::ffi::c_int;
        }
        // SAFETY: declared as in malloc.h. It takes the locks of the heaps, and touches only pages that no allocation lies on.
        unsafe { malloc_trim(0) };
    }
}
