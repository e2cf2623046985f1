//! Captures by RenderDoc, when this process runs under it.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::PathBuf;
use std::ptr::null_mut;

/// Version 1.1.2 of the API, which every RenderDoc since 2018 offers.
const VERSION: c_int = 10_102;

type GetApi = unsafe extern "C" fn(version: c_int, api: *mut *mut c_void) -> c_int;

/// `RENDERDOC_API_1_1_2` of `renderdoc_app.h`: pointers to functions. raxel uses some of them.
#[repr(C)]
#[derive(Clone, Copy)]
struct Api {
    version_to_template: [*const c_void; 13],
    get_num_captures: unsafe extern "C" fn() -> u32,
    get_capture: unsafe extern "C" fn(index: u32, name: *mut c_char, length: *mut u32, time: *mut u64) -> u32,
    trigger_to_window: [*const c_void; 4],
    start_frame_capture: unsafe extern "C" fn(device: *mut c_void, window: *mut c_void),
    is_frame_capturing: *const c_void,
    end_frame_capture: unsafe extern "C" fn(device: *mut c_void, window: *mut c_void) -> u32,
}

/// The RenderDoc that was loaded into this process before it opened a device.
pub struct RenderDoc {
    api: *const Api,
    // The functions live in it.
    _library: Library,
}

#[cfg(unix)]
type Library = libloading::os::unix::Library;
#[cfg(windows)]
type Library = libloading::os::windows::Library;

/// The library, if it is loaded; it is never loaded here, since a device that is open already could not be captured any more.
#[cfg(unix)]
fn loaded() -> Option<Library> {
    const MACOS: bool = cfg!(target_os = "macos");
    /// `RTLD_NOW | RTLD_NOLOAD`.
    const FLAGS: c_int = if MACOS { 0x2 | 0x10 } else { 0x2 | 0x4 };
    let name = if MACOS { "librenderdoc.dylib" } else { "librenderdoc.so" };
    // SAFETY: with `RTLD_NOLOAD` nothing is loaded, so that no initialiser runs.
    unsafe { Library::open(Some(name), FLAGS) }.ok()
}

/// The library, if it is loaded; see above.
#[cfg(windows)]
fn loaded() -> Option<Library> {
    Library::open_already_loaded("renderdoc.dll").ok()
}

impl RenderDoc {
    /// The RenderDoc of this process, if it runs under it.
    pub fn find() -> Option<RenderDoc> {
        let library = loaded()?;
        let mut api: *mut c_void = null_mut();
        // SAFETY: RenderDoc exports this function with this signature; `api` lives until it returns.
        let found = unsafe {
            let get_api = library.get::<GetApi>(b"RENDERDOC_GetAPI\0").ok()?;
            get_api(VERSION, &raw mut api)
        };
        (found == 1 && !api.is_null()).then_some(RenderDoc { api: api.cast_const().cast(), _library: library })
    }

    /// Captures the submissions of `work`, and returns the file of the capture, if RenderDoc has made one.
    pub fn capture<T>(&self, work: impl FnOnce() -> T) -> (T, Option<PathBuf>) {
        // SAFETY: RenderDoc gave a table of this version, which lives as long as its library.
        let api = unsafe { self.api.read() };
        // SAFETY: null means any device without a window; begin and end are paired by the lines below.
        unsafe { (api.start_frame_capture)(null_mut(), null_mut()) };
        let result = work();
        // SAFETY: as above.
        let made = unsafe { (api.end_frame_capture)(null_mut(), null_mut()) } == 1;
        (result, made.then(|| newest(&api)).flatten())
    }
}

/// The file of the newest capture.
fn newest(api: &Api) -> Option<PathBuf> {
    // SAFETY: a query without arguments.
    let index = unsafe { (api.get_num_captures)() }.checked_sub(1)?;
    let mut length = 0;
    // SAFETY: without a buffer only the length is written, the terminating zero included.
    let found = unsafe { (api.get_capture)(index, null_mut(), &raw mut length, null_mut()) };
    if found != 1 || length == 0 {
        return None;
    }
    let mut name = vec![0_u8; length as usize];
    // SAFETY: the buffer has the length that was asked for.
    unsafe { (api.get_capture)(index, name.as_mut_ptr().cast(), &raw mut length, null_mut()) };
    Some(CStr::from_bytes_until_nul(&name).ok()?.to_str().ok()?.into())
}
