//! Triangles over a picture, drawn into an image and read back.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::sync::Arc;
use std::time::Duration;

use raxel_gpu::{
    Backing, Barrier, CommandBuffer, Device, DeviceOptions, Image, ImageInfo, ImageView, OverlayFrame, OverlayMesh,
    OverlayVertex, TexturePatch, Validation, ViewInfo, download_image, vk,
};
use raxel_runtime::present::new_overlay;

const SIDE: u32 = 16;
const PATIENCE: Duration = Duration::from_secs(60);

/// Two triangles over a rectangle of points, with a texture stretched over them.
fn quad([left, top, right, bottom]: [f32; 4], color: [u8; 4]) -> [OverlayVertex; 4] {
    let corner = |x, y, u, v| OverlayVertex { position: [x, y], uv: [u, v], color };
    [
        corner(left, top, 0.0, 0.0),
        corner(right, top, 1.0, 0.0),
        corner(right, bottom, 1.0, 1.0),
        corner(left, bottom, 0.0, 1.0),
    ]
}

const INDICES: [u32; 6] = [0, 1, 2, 0, 2, 3];

const WHOLE: [f32; 4] = [0.0, 0.0, 16.0, 16.0];

/// A target of a format, filled with one colour.
struct Target {
    device: Arc<Device>,
    image: Arc<Image>,
    view: Arc<ImageView>,
    commands: CommandBuffer,
}

impl Target {
    fn new(format: vk::Format) -> Self {
        let options = DeviceOptions { device: None, validation: Validation::Required };
        let device = Device::new(&options).expect("a driver and the validation layer");
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let info = ImageInfo { format, volume: false, extent: [SIDE, SIDE, 1], mips: 1, layers: 1, usage };
        let image = Arc::new(Image::new(&device, "target", &info, Backing::Own).expect("it fits"));
        let view = Arc::new(ImageView::new(&device, &image, &ViewInfo::FLAT).expect("a view"));
        let commands = CommandBuffer::new(&device, "draw").expect("a pool");
        Self { device, image, view, commands }
    }

    /// Clears to a colour, draws, and reads the pixels.
    fn draw(
        &mut self,
        overlay: &mut raxel_gpu::Overlay,
        clear: [f32; 4],
        frame: usize,
        content: &OverlayFrame<'_>,
    ) -> (u32, Vec<[u8; 4]>) {
        self.device.wait(self.commands.submitted(), PATIENCE).expect("it ends");
        let mut recording = self.commands.begin().expect("it has ended");
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let any = vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE;
        recording.barrier(&Barrier::default().activate(&self.image, (all, any), (all, any)));
        recording.clear_image(&self.image, raxel_gpu::ClearColor::Float(clear));
        let drawn = overlay.draw_into(&mut recording, &self.view, frame, content).expect("it is drawn");
        recording.submit().expect("it runs");
        let bytes = download_image(&self.device, &self.image, 4, 0, 0, PATIENCE).expect("it is read");
        (drawn, bytes.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2], pixel[3]]).collect())
    }

    fn silent(&self) {
        let messages = self.device.log().take();
        assert!(messages.is_empty(), "{messages:#?}");
    }
}

const WHITE: TexturePatch<'_> = TexturePatch { position: None, size: [1, 1], rgba: &[255; 4], linear: false };

fn at(pixels: &[[u8; 4]], x: u32, y: u32) -> [u8; 4] {
    pixels[(y * SIDE + x) as usize]
}

#[test]
fn triangles_are_coloured_clipped_and_blended_over_the_picture() {
    let mut target = Target::new(vk::Format::R8G8B8A8_UNORM);
    let mut overlay = new_overlay(&target.device, vk::Format::R8G8B8A8_UNORM).expect("the shaders compile");
    overlay.set_texture(7, &WHITE).expect("it fits");
    let opaque = quad([2.0, 2.0, 6.0, 6.0], [255, 0, 0, 255]);
    // Half as opaque, over everything; clipped to the right half.
    let glass = quad(WHOLE, [0, 0, 128, 128]);
    let missing = quad(WHOLE, [255; 4]);
    let mesh = |clip, texture, vertices| OverlayMesh { clip, texture, vertices, indices: &INDICES };
    let meshes = [
        mesh(WHOLE, 7, &opaque[..]),
        mesh([8.0, 0.0, 16.0, 16.0], 7, &glass[..]),
        // A texture that is not there, a clip without area, an index outside: each is left out.
        mesh(WHOLE, 8, &missing[..]),
        mesh([4.0, 4.0, 4.0, 9.0], 7, &missing[..]),
        mesh(WHOLE, 7, &missing[..3]),
    ];
    let content = OverlayFrame { pixels_per_point: 1.0, meshes: &meshes };
    let (drawn, pixels) = target.draw(&mut overlay, [0.0, 1.0, 0.0, 1.0], 0, &content);
    assert_eq!(drawn, 2);
    assert_eq!(at(&pixels, 0, 0), [0, 255, 0, 255], "the picture under it stays");
    assert_eq!((at(&pixels, 2, 2), at(&pixels, 5, 5)), ([255, 0, 0, 255], [255, 0, 0, 255]));
    assert_eq!((at(&pixels, 6, 5), at(&pixels, 1, 2)), ([0, 255, 0, 255], [0, 255, 0, 255]));
    assert_eq!(at(&pixels, 7, 8), [0, 255, 0, 255], "clipped");
    // 128 over 255: encoded values are blended, as interfaces are drawn.
    assert_eq!(at(&pixels, 8, 8), [0, 127, 128, 255]);
    target.silent();
}

#[test]
fn points_scale_to_pixels_and_buffers_grow() {
    let mut target = Target::new(vk::Format::R8G8B8A8_UNORM);
    let mut overlay = new_overlay(&target.device, vk::Format::R8G8B8A8_UNORM).expect("the shaders compile");
    overlay.set_texture(0, &WHITE).expect("it fits");
    for (frame, count) in [(0, 1_usize), (1, 300), (0, 3000), (1, 2)] {
        let vertices: Vec<OverlayVertex> =
            (0..count).flat_map(|_| quad([1.0, 1.0, 3.0, 3.0], [255, 255, 255, 255])).collect();
        let indices: Vec<u32> = (0..count as u32).flat_map(|quad| INDICES.map(|index| quad * 4 + index)).collect();
        let meshes = [OverlayMesh { clip: [0.0, 0.0, 4.0, 4.0], texture: 0, vertices: &vertices, indices: &indices }];
        let content = OverlayFrame { pixels_per_point: 4.0, meshes: &meshes };
        let (drawn, pixels) = target.draw(&mut overlay, [0.0; 4], frame, &content);
        assert_eq!(drawn, 1);
        for y in 0..SIDE {
            for x in 0..SIDE {
                let inside = (4..12).contains(&x) && (4..12).contains(&y);
                assert_eq!(at(&pixels, x, y), [if inside { 255 } else { 0 }; 4], "{count} quads at {x}, {y}");
            }
        }
    }
    target.silent();
}

#[test]
fn textures_are_sampled_and_changed_in_part() {
    let mut target = Target::new(vk::Format::R8G8B8A8_UNORM);
    let mut overlay = new_overlay(&target.device, vk::Format::R8G8B8A8_UNORM).expect("the shaders compile");
    let grey = |value: u8| [value, value, value, 255];
    let texels: Vec<u8> = [grey(10), grey(20), grey(30), grey(40)].concat();
    overlay.set_texture(1, &TexturePatch { size: [2, 2], rgba: &texels, ..WHITE }).expect("it fits");
    let vertices = quad(WHOLE, [255; 4]);
    let meshes = [OverlayMesh { clip: WHOLE, texture: 1, vertices: &vertices, indices: &INDICES }];
    let content = OverlayFrame { pixels_per_point: 1.0, meshes: &meshes };
    let corners =
        |pixels: &[[u8; 4]]| [at(pixels, 0, 0)[0], at(pixels, 15, 0)[0], at(pixels, 0, 15)[0], at(pixels, 15, 15)[0]];
    let (_, pixels) = target.draw(&mut overlay, [0.0; 4], 0, &content);
    assert_eq!(corners(&pixels), [10, 20, 30, 40]);
    let patch = TexturePatch { position: Some([1, 1]), size: [1, 1], rgba: &grey(99), linear: false };
    overlay.set_texture(1, &patch).expect("it is inside");
    let (_, pixels) = target.draw(&mut overlay, [0.0; 4], 1, &content);
    assert_eq!(corners(&pixels), [10, 20, 30, 99]);
    // Outside, of the wrong size, of a texture that is not there.
    for wrong in [
        TexturePatch { position: Some([2, 1]), ..patch },
        TexturePatch { size: [2, 1], ..patch },
        TexturePatch { size: [0, 0], rgba: &[], ..patch },
    ] {
        assert!(overlay.set_texture(1, &wrong).is_err());
    }
    assert!(overlay.set_texture(2, &patch).is_err());
    overlay.free_texture(1);
    assert_eq!(target.draw(&mut overlay, [0.0; 4], 0, &content).0, 0);
    target.silent();
}

#[test]
fn a_target_that_encodes_shows_the_same_colours() {
    let mut target = Target::new(vk::Format::R8G8B8A8_SRGB);
    let mut overlay = new_overlay(&target.device, vk::Format::R8G8B8A8_SRGB).expect("the shaders compile");
    overlay.set_texture(0, &WHITE).expect("it fits");
    let vertices = quad(WHOLE, [200, 100, 3, 255]);
    let meshes = [OverlayMesh { clip: WHOLE, texture: 0, vertices: &vertices, indices: &INDICES }];
    let content = OverlayFrame { pixels_per_point: 1.0, meshes: &meshes };
    let (_, pixels) = target.draw(&mut overlay, [0.0; 4], 0, &content);
    let [r, g, b, a] = at(&pixels, 8, 8);
    assert!(r.abs_diff(200) <= 1 && g.abs_diff(100) <= 1 && b.abs_diff(3) <= 1 && a == 255, "{:?}", [r, g, b, a]);
    target.silent();
}
