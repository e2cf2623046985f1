//! The brush that edits the world, and what it can do.

/// The shape of a brush.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shape {
    /// The voxel under the cursor.
    Voxel,
    /// A cube.
    Box,
    /// A ball.
    #[default]
    Sphere,
    /// A cylinder that stands on the face under the cursor.
    Cylinder,
}

impl Shape {
    /// Every shape, in the order of the panel.
    pub const ALL: [Shape; 4] = [Shape::Voxel, Shape::Box, Shape::Sphere, Shape::Cylinder];

    /// Its name.
    pub fn word(self) -> &'static str {
        match self {
            Shape::Voxel => "voxel",
            Shape::Box => "box",
            Shape::Sphere => "sphere",
            Shape::Cylinder => "cylinder",
        }
    }
}

/// The effect of a brush.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effect {
    /// Voxels become solid, in front of the face under the cursor.
    Add,
    /// Voxels become air.
    #[default]
    Subtract,
    /// Solid voxels get another material.
    Paint,
    /// The material under the cursor becomes that of the brush.
    Pick,
}

impl Effect {
    /// Every effect, in the order of the panel.
    pub const ALL: [Effect; 4] = [Effect::Add, Effect::Subtract, Effect::Paint, Effect::Pick];

    /// Its name.
    pub fn word(self) -> &'static str {
        match self {
            Effect::Add => "add",
            Effect::Subtract => "subtract",
            Effect::Paint => "paint",
            Effect::Pick => "pick",
        }
    }

    /// Its effect, in a sentence.
    pub fn about(self) -> &'static str {
        match self {
            Effect::Add => "Voxels in front of the face under the cursor become solid.",
            Effect::Subtract => "Voxels become air.",
            Effect::Paint => "Solid voxels get the material of the brush.",
            Effect::Pick => "The brush gets the material under the cursor.",
        }
    }

    /// Its effect while Shift is held.
    #[must_use]
    pub fn opposite(self) -> Self {
        match self {
            Effect::Add => Effect::Subtract,
            Effect::Subtract => Effect::Add,
            Effect::Paint => Effect::Pick,
            Effect::Pick => Effect::Paint,
        }
    }
}

/// The effect of the right mouse button on voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Brush {
    /// Its shape.
    pub shape: Shape,
    /// Its effect there.
    pub effect: Effect,
    /// Voxels across; of a cylinder, its diameter.
    pub size: u32,
    /// Voxels from base to top of a cylinder.
    pub height: u32,
    /// Palette index; `None` for the material under the cursor.
    pub material: Option<u16>,
}

impl Brush {
    /// Most voxels across, and most voxels of height.
    pub const LARGEST: u32 = 512;
}

impl Default for Brush {
    fn default() -> Self {
        Self { shape: Shape::default(), effect: Effect::default(), size: 9, height: 9, material: None }
    }
}

/// A material of the palette.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Swatch {
    /// Palette index.
    pub material: u16,
    /// Name.
    pub name: String,
    /// Albedo in sRGB.
    pub color: [u8; 3],
}

/// How the world can be edited.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Editing<'a> {
    /// The brush.
    pub brush: Brush,
    /// Materials to choose from.
    pub materials: &'a [Swatch],
    /// Steps that can be undone, and redone.
    pub steps: [usize; 2],
    /// Why the last edit was not made.
    pub refused: Option<String>,
    /// Material and place of the voxel under the cursor.
    pub under: Option<String>,
    /// Lines around what a press of the button would reach: their ends in pixels, from the top left.
    pub outline: Vec<[[f32; 2]; 2]>,
}
