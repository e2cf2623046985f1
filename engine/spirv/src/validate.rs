//! Asks the Khronos validator (SPIRV-Tools, `spirv-val`) whether a SPIR-V module may be given to a driver. It comes with the shader
//! compiler, which uses the same library. Drivers trust their input, and some crash on invalid modules.

#![allow(unsafe_code, reason = "the validator is a C interface; each block says why it is sound")]

use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr;

// Links the compiler's library; nothing of the crate is called by name.
use shaderc_sys as _;

/// `SPV_ENV_VULKAN_1_3` of `spv_target_env` in `spirv-tools/libspirv.h`.
const ENV_VULKAN_1_3: c_int = 25;
/// `SPV_SUCCESS` of `spv_result_t`.
const SUCCESS: c_int = 0;

/// `spv_const_binary_t`.
#[repr(C)]
struct Binary {
    code: *const u32,
    words: usize,
}

/// `spv_diagnostic_t`.
#[repr(C)]
struct Diagnostic {
    line: usize,
    column: usize,
    index: usize,
    error: *mut c_char,
    is_text_source: bool,
}

unsafe extern "C" {
    fn spvContextCreate(env: c_int) -> *mut c_void;
    fn spvContextDestroy(context: *mut c_void);
    fn spvValidatorOptionsCreate() -> *mut c_void;
    fn spvValidatorOptionsDestroy(options: *mut c_void);
    fn spvValidatorOptionsSetScalarBlockLayout(options: *mut c_void, value: bool);
    fn spvValidateWithOptions(
        context: *mut c_void,
        options: *mut c_void,
        binary: *const Binary,
        diagnostic: *mut *mut Diagnostic,
    ) -> c_int;
    fn spvDiagnosticDestroy(diagnostic: *mut Diagnostic);
}

/// Checks a module against the rules of SPIR-V and of Vulkan 1.3. On failure, the rule that it breaks.
///
/// # Errors
/// The validator's message, in one line.
pub fn validate(words: &[u32]) -> Result<(), String> {
    // SAFETY: takes a value of the enumeration and returns an object that is owned here, or null.
    let context = unsafe { spvContextCreate(ENV_VULKAN_1_3) };
    if context.is_null() {
        return Err("the validator does not start".to_owned());
    }
    // SAFETY: no arguments; returns an object that is owned here.
    let options = unsafe { spvValidatorOptionsCreate() };
    let binary = Binary { code: words.as_ptr(), words: words.len() };
    let mut diagnostic = ptr::null_mut();
    // SAFETY: `options` is alive. Context, options and binary are alive during the call, `binary` describes `words`, which is only
    // read, and `diagnostic` is set to null or to an object that is owned here.
    let result = unsafe {
        spvValidatorOptionsSetScalarBlockLayout(options, true);
        spvValidateWithOptions(context, options, &raw const binary, &raw mut diagnostic)
    };
    // SAFETY: the validator sets `diagnostic` to null or to an object whose `error` is null or a string that ends in a zero byte;
    // both live until `spvDiagnosticDestroy`, and the text is copied.
    let message = unsafe {
        diagnostic.as_ref().filter(|said| !said.error.is_null()).map(|said| {
            let text = CStr::from_ptr(said.error).to_string_lossy();
            text.split_whitespace().collect::<Vec<_>>().join(" ")
        })
    };
    // SAFETY: each object was made above, is not used after this, and is destroyed once; a null diagnostic is allowed.
    unsafe {
        spvDiagnosticDestroy(diagnostic);
        spvValidatorOptionsDestroy(options);
        spvContextDestroy(context);
    }
    if result == SUCCESS { Ok(()) } else { Err(message.unwrap_or_else(|| format!("the validator says {result}"))) }
}

#[cfg(test)]
mod tests {
    use super::validate;

    /// `void main() {}` with one invocation: capability, memory model, entry point, local size, void, its function type, function.
    fn smallest() -> Vec<u32> {
        let mut words = vec![0x0723_0203, 0x0001_0600, 0, 5, 0, 0x0002_0011, 1, 0x0003_000e, 0, 1];
        words.extend([0x0005_000f, 5, 2, u32::from_le_bytes(*b"main"), 0, 0x0006_0010, 2, 17, 1, 1, 1]);
        words.extend([0x0002_0013, 1, 0x0003_0021, 4, 1]);
        words.extend([0x0005_0036, 1, 2, 0, 4, 0x0002_00f8, 3, 0x0001_00fd, 0x0001_0038]);
        words
    }

    #[test]
    fn tells_valid_from_invalid() {
        assert_eq!(validate(&smallest()), Ok(()));
        assert!(validate(&[]).is_err());
        assert!(validate(&smallest()[..20]).is_err());
        let mut kernel = smallest();
        kernel[6] = 6;
        let said = validate(&kernel).unwrap_err();
        // Which of the two is named depends on the version of SPIRV-Tools.
        assert!((said.contains("Kernel") || said.contains("MemoryModel")) && !said.contains('\n'), "{said}");
        let mut undefined = smallest();
        let last = undefined.len() - 2;
        undefined[last] = 0x0002_00fe;
        undefined.insert(last + 1, 4);
        assert!(validate(&undefined).is_err());
    }
}
