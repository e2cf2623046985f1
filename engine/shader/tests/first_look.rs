//! A first look at edited files finds what the compiler finds in them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use raxel_diagnostics::{Diagnostic, DiskFiles, FileError, Files, SourceMap};
use raxel_shader::{Compiler, FirstLook, Request, ShaderProvider};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// One request for each shader of the graphs at the top, as the first pass asks for it.
fn requests() -> Vec<Request> {
    let mut requests = BTreeMap::new();
    let mut graphs: Vec<PathBuf> =
        std::fs::read_dir(root().join("graphs")).unwrap().map(|entry| entry.unwrap().path()).collect();
    graphs.sort();
    for text in graphs.iter().filter_map(|path| std::fs::read_to_string(path).ok()) {
        let value = |text: &str, key: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(key)?.trim_start().strip_prefix('='))?.trim();
            line.split(['"', '{', '}']).nth(1).map(str::to_owned)
        };
        let sources = text.lines().filter(|line| line.contains("source"));
        let mut layouts = sources.filter_map(|line| line.split("\"world.").nth(1)?.split('"').next());
        let layout = layouts.find(|layout| *layout != "instances").unwrap_or("tree64").to_uppercase();
        for pass in text.split("[[passes]]").skip(1) {
            let Some(shader) = value(pass, "shader") else { continue };
            let defines = value(pass, "defines").unwrap_or_default();
            let defines = defines.split(',').filter_map(|define| define.split_once('='));
            let mut defines: Vec<(String, String)> =
                defines.map(|(name, value)| (name.trim().to_owned(), value.trim().replace('"', ""))).collect();
            defines.push((format!("RX_LAYOUT_{layout}"), "1".to_owned()));
            let path = format!("shaders/{shader}");
            requests.entry(path.clone()).or_insert(Request { path, entry: "main".to_owned(), defines });
        }
    }
    requests.into_values().collect()
}

/// The files of the repository, one of them with another text.
struct Edited {
    disk: DiskFiles,
    edit: Mutex<(String, String)>,
}

impl Files for Edited {
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError> {
        let edit = self.edit.lock().unwrap();
        if edit.0 == path { Ok(edit.1.as_bytes().into()) } else { self.disk.read(path) }
    }
}

/// Errors in an edited shader or include are those of the whole shader.
#[test]
fn a_first_look_finds_the_errors_of_edited_files() {
    let files = Arc::new(Edited { disk: DiskFiles::new(&root()).unwrap(), edit: Mutex::default() });
    let compiler = Compiler::new(files.clone());
    let (mut found, mut sure) = (0, 0);
    for request in requests() {
        let texts = SourceMap::default;
        let (shader, _) = compiler.shader(&request, &mut texts()).unwrap();
        let include = shader.files[1..].iter().rev().find(|file| file.contains("light/")).or(shader.files.last());
        for file in [&request.path].into_iter().chain(include) {
            let text = std::fs::read_to_string(root().join(file)).unwrap();
            let Some(end) = text.rfind('}') else { continue };
            let edited = BTreeSet::from([file.clone()]);
            for wrong in ["", "float wrong = nowhere;", "int wrong = vec3(nowhere(1.0));", "float wrong = 1.0", "}"] {
                *files.edit.lock().unwrap() =
                    (file.clone(), format!("{}{wrong}{}// edited", &text[..end], &text[end..]));
                let look = FirstLook::new(&compiler, &edited);
                let looked = look.shader(&request, &mut texts()).unwrap_err();
                let mut errors = compiler.shader(&request, &mut texts()).err().unwrap_or_default();
                assert!(looked.iter().all(|error| errors.contains(error)), "{file}, {wrong}: {looked:#?}\n{errors:#?}");
                if look.is_sure() {
                    errors.retain(Diagnostic::is_error);
                    assert_eq!(looked, errors, "{file}, {wrong}");
                    sure += 1;
                }
                found += looked.len();
            }
        }
        files.edit.lock().unwrap().0.clear();
    }
    assert!(found > 150 && sure > 180, "{found} errors, {sure} looks are sure");
}
