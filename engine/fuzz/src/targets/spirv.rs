//! SPIR-V modules from files: they are read or refused, for any words; and valid ones stay valid in every copy that raxel makes.

use std::sync::Arc;

use raxel_diagnostics::{MemoryFiles, SourceMap};
use raxel_shader::{Compiler, Request, ShaderProvider};
use raxel_spirv::{Module, bytes_of, validate, words_of};

use crate::bounds::Bounds;
use crate::{Mutation, Target, check};

pub(crate) const TARGET: Target = Target {
    name: "spirv",
    run,
    // A few words may declare an id bound of four million, and types whose written-out size is a million.
    bounds: Bounds { bytes: 512 << 20, ..Bounds::PARSER },
    mutation: Mutation::Spirv,
    seeds: &[],
    longest: 16 << 10,
    quick: 500,
};

/// The file of the input.
const PATH: &str = "shaders/main.spv";

fn run(input: &[u8]) {
    let compiler = Compiler::new(Arc::new(MemoryFiles::new([(PATH, input)]))).with_cache(None);
    let request = Request { path: PATH.to_owned(), entry: "main".to_owned(), defines: Vec::new() };
    let mut texts = SourceMap::default();
    texts.insert(PATH, "");
    let taken = check::outcome(compiler.shader(&request, &mut texts), &texts);

    let Ok(words) = words_of(input) else {
        assert!(taken.is_none(), "a module of no words");
        return;
    };
    assert_eq!(bytes_of(&words), input);
    let Ok(module) = Module::new(&words, "main") else {
        assert!(taken.is_none(), "the structure of the module is refused, and the module is taken");
        return;
    };
    asked(&module);
    if let Some(shader) = &taken {
        assert_eq!(validate(&shader.spirv), Ok(()), "what the driver is given is not valid");
        let module = Module::new(&shader.spirv, "main").expect("what the driver is given can be read");
        assert!(module.with_separate_bindings().is_none(), "two bindings share a place");
        assert!(module.with_shared_bounds() == Ok(None), "an access to shared memory has no bound");
        assert_eq!(shader.interface.capabilities, module.capabilities());
    }
    if validate(&words).is_err() {
        assert!(taken.is_none(), "a module that is not valid is taken");
        return;
    }
    // A module that no bounds can be written into is refused.
    let Ok(bounded) = module.with_shared_bounds() else {
        assert!(taken.is_none(), "a module without bounds is taken");
        return;
    };
    let copies = [
        ("separate bindings", module.with_separate_bindings()),
        ("shared bounds", bounded),
        ("opaque uniforms", module.with_opaque_uniforms()),
        ("no debug text", Some(module.without_debug_text())),
    ];
    for (name, copy) in copies {
        let Some(copy) = copy else { continue };
        assert_eq!(validate(&copy), Ok(()), "the copy with {name}");
        let again = Module::new(&copy, "main").unwrap_or_else(|error| panic!("the copy with {name}: {error}"));
        assert_eq!(again.workgroup_size(), module.workgroup_size(), "the copy with {name}");
        assert_eq!(again.capabilities(), module.capabilities(), "the copy with {name}");
        assert_eq!(again.memory().shared, module.memory().shared, "the copy with {name}");
    }
}

/// Every question has an answer, for any words.
fn asked(module: &Module<'_>) {
    let used = module.used_ids();
    let _ = (module.declarations(), module.workgroup_size(), module.buffer_blocks(), module.chains(&used));
    assert!(module.undefined().iter().all(|found| !found.reason.is_empty()));
    assert!(module.capabilities().iter().all(|name| !name.is_empty()));
    let bounded = module.with_shared_bounds().unwrap_or_default();
    for copy in [module.with_separate_bindings(), bounded, module.with_opaque_uniforms()].into_iter().flatten() {
        assert!(words_of(&bytes_of(&copy)).is_ok_and(|words| words == copy), "a copy is not read as it was written");
    }
}

#[cfg(test)]
mod tests {
    use raxel_world::random::SplitMix64;

    use super::*;

    /// A module that the validator refuses reaches little of raxel.
    #[test]
    fn many_mutations_are_valid() {
        let inputs = TARGET.inputs();
        let is_valid = |seed: &u64| {
            let mut random = SplitMix64::new(*seed);
            let [input, other] = [(); 2].map(|()| &inputs[random.index(inputs.len())].1);
            let words = words_of(&TARGET.mutated(input, other, &mut random)).unwrap_or_default();
            Module::new(&words, "main").is_ok() && validate(&words).is_ok()
        };
        let valid = (0..400).filter(is_valid).count();
        assert!(valid > 40, "{valid} of 400 mutations are valid");
    }
}
