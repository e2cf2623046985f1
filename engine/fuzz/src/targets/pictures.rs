//! PNG and EXR files: as targets of a graph in every way that a graph can want them, and as pictures that are compared.

use std::sync::Arc;

use raxel_diagnostics::MemoryFiles;
use raxel_graph::FileContents;
use raxel_graph::checked::{Origin, ResourceKind};
use raxel_runtime::load::Loader;

use crate::bounds::Bounds;
use crate::{Mutation, Target, check};

pub(crate) const PNG: Target = Target {
    name: "png",
    run: |input| run("textures/a.png", input),
    bounds: BOUNDS,
    mutation: Mutation::Png,
    seeds: &[],
    longest: 4 << 10,
    quick: 500,
};

pub(crate) const EXR: Target = Target {
    name: "exr",
    run: |input| run("textures/a.exr", input),
    bounds: BOUNDS,
    mutation: Mutation::Binary,
    seeds: &[],
    longest: 4 << 10,
    quick: 500,
};

/// Pictures are compressed: a byte of the file stands for that many bytes of texels, several times over.
const BOUNDS: Bounds = Bounds { bytes_per_byte: 32 << 10, ..Bounds::PARSER };

/// Formats that a graph can ask of a picture.
const WANTED: [(&str, &str); 5] = [
    ("plain", ""),
    ("mips", "mips = \"full\"\n"),
    ("srgb", "encoding = \"srgb\"\nmips = \"full\"\n"),
    ("strip", "slices = 2\nmips = \"full\"\n"),
    ("float", "format = \"rgba32f\"\n"),
];

thread_local! {
    /// A project with a graph for each wish. Its shader is compiled once.
    static PROJECT: (Arc<MemoryFiles>, Loader) = {
        let files = Arc::new(MemoryFiles::default());
        files.insert(
            "shaders/fill.comp",
            "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout(rgba8) writeonly uniform image2D o;\n\
             void main() { imageStore(o, ivec2(gl_GlobalInvocationID.xy), vec4(1.0)); }\n",
        );
        (files.clone(), Loader::with_files(files))
    };
}

fn run(path: &str, input: &[u8]) {
    match raxel_picture::decode(input, None) {
        Ok(picture) => {
            let (width, height) = (picture.width as usize, picture.height as usize);
            assert!(width > 0 && height > 0 && picture.pixels.len() == width * height, "{width} x {height}");
        }
        Err(error) => assert!(!error.to_string().trim().is_empty()),
    }
    PROJECT.with(|(files, loader)| {
        files.insert(path, input);
        for (name, keys) in WANTED {
            let graph = format!("graphs/{name}.toml");
            let text = format!(
                "name = \"{name}\"\npresent = \"color\"\n[targets.picture]\nsource = \"file.{path}\"\n{keys}[targets.color]\nformat = \"rgba8\"\n\
                 [[passes]]\nname = \"fill\"\nshader = \"fill.comp\"\ndispatch = {{ threads = \"color\" }}\nbind = {{ o = \"color\" }}\n"
            );
            files.insert(graph.as_str(), text);
            let part = loader.graph(&graph);
            check::diagnostics(part.found(), &part.texts);
            let Ok(graph) = &part.result else { continue };
            let resource = graph.resources.iter().find(|resource| resource.name == "picture").expect("it is declared");
            let (Origin::File(contents), ResourceKind::Target(_)) = (&resource.origin, &resource.kind) else {
                panic!("the picture is no picture: {resource:?}");
            };
            let FileContents::Image(image) = &**contents else { panic!("a picture without texels") };
            let mut extent = image.extent;
            for mip in &image.mips {
                let texels: u64 = extent.iter().map(|side| u64::from(*side)).product();
                assert_eq!(mip.len() as u64, texels * u64::from(image.format.bytes()), "{image:?}");
                extent = extent.map(|side| (side / 2).max(1));
            }
            assert!(!image.mips.is_empty() && image.volume == (name == "strip"), "{image:?}");
        }
    });
}
