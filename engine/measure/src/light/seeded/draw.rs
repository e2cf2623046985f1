//! Random draws of a seed, and the text of a world file.

use std::fmt::Write;

use raxel_world::random::{SplitMix64, mix};

/// Random numbers of one scene.
pub(super) struct Draw(SplitMix64);

impl Draw {
    /// The numbers of an attempt at a scene.
    pub(super) fn new(parts: [u64; 4]) -> Self {
        Self(SplitMix64::new(parts.into_iter().fold(0, |state, part| mix(state.wrapping_add(part).wrapping_add(1)))))
    }

    /// A whole number, both ends included.
    #[expect(clippy::cast_possible_wrap, clippy::cast_possible_truncation, reason = "both ends are 32-bit integers")]
    pub(super) fn int(&mut self, least: i32, most: i32) -> i32 {
        let span = i64::from(most) - i64::from(least) + 1;
        (i64::from(least) + self.0.below(span.unsigned_abs()) as i64) as i32
    }

    /// A multiple of 1/64, so that the text of a file has the same number as the program.
    pub(super) fn number(&mut self, least: f64, most: f64) -> f64 {
        let part = self.0.below(1 << 20) as f64 / f64::from(1 << 20);
        ((least + (most - least) * part) * 64.0).round() / 64.0
    }

    /// Whether something with this probability happens.
    pub(super) fn chance(&mut self, probability: f64) -> bool {
        (self.0.below(1 << 20) as f64) < probability * f64::from(1 << 20)
    }

    /// One of a list that is not empty.
    pub(super) fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.0.index(of.len())]
    }

    /// An sRGB colour: a grey between two values with a tint.
    pub(super) fn color(&mut self, least: i32, most: i32) -> [u8; 3] {
        let grey = self.int(least, most);
        std::array::from_fn(|_| u8::try_from((grey + self.int(-44, 44)).clamp(12, 252)).unwrap_or(0))
    }
}

/// The text of a world file.
#[derive(Default)]
pub(super) struct Text {
    materials: String,
    build: String,
    /// `[stream]` of a world that is streamed.
    pub stream: Option<String>,
    /// Middles of its lamps, as far as they are known.
    pub lamps: Vec<[f64; 3]>,
}

impl Text {
    /// A matt material.
    pub(super) fn material(&mut self, name: &str, [r, g, b]: [u8; 3]) {
        let _ = writeln!(self.materials, "{name} = {{ albedo = \"#{r:02x}{g:02x}{b:02x}\" }}");
    }

    /// A material that gives off light.
    pub(super) fn lamp(&mut self, name: &str, [r, g, b]: [u8; 3], emission: f64) {
        let _ = writeln!(self.materials, "{name} = {{ albedo = \"#{r:02x}{g:02x}{b:02x}\", emission = {emission:?} }}");
    }

    /// An operation as it stands in the file, without its braces.
    pub(super) fn op(&mut self, operation: &str) {
        let _ = writeln!(self.build, "  {{ {operation} }},");
    }

    /// A box of a material.
    pub(super) fn cuboid(&mut self, material: &str, min: [i32; 3], max: [i32; 3]) {
        self.op(&format!("op = \"box\", min = {min:?}, max = {max:?}, material = \"{material}\""));
    }

    /// A box of a material that lights its surroundings.
    pub(super) fn light(&mut self, material: &str, min: [i32; 3], max: [i32; 3]) {
        self.cuboid(material, min, max);
        self.lamps.push(std::array::from_fn(|axis| f64::midpoint(f64::from(min[axis]), f64::from(max[axis]))));
    }

    /// A box of air.
    pub(super) fn hole(&mut self, min: [i32; 3], max: [i32; 3]) {
        self.op(&format!("op = \"box\", mode = \"subtract\", min = {min:?}, max = {max:?}"));
    }

    /// Another material on solid voxels.
    pub(super) fn paint(&mut self, material: &str, min: [i32; 3], max: [i32; 3]) {
        self.op(&format!("op = \"box\", mode = \"paint\", min = {min:?}, max = {max:?}, material = \"{material}\""));
    }

    /// The file: keys at its head, then tables.
    pub(super) fn file(&self, head: &str, tables: &str) -> String {
        let Self { materials, build, stream, .. } = self;
        let stream = stream.as_deref().unwrap_or_default();
        format!("{head}\nbuild = [\n{build}]\n\n{stream}[materials]\n{materials}{tables}")
    }
}
