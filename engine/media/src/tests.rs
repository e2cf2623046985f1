use std::io::Cursor;
use std::sync::Arc;

use ::exr::prelude::{
    AnyChannel, AnyChannels, FlatSamples, Image, Layer, LayerAttributes, SmallVec, Text, WritableImage, f16,
};
use ::png::{BitDepth, ColorType, Encoder};
use raxel_diagnostics::MemoryFiles;
use raxel_shader::format::Format;

use super::*;

fn png(bytes: &[u8], extent: [u32; 2], color: ColorType) -> Vec<u8> {
    png_of(bytes, extent, color, BitDepth::Eight)
}

fn png_of(bytes: &[u8], extent: [u32; 2], color: ColorType, depth: BitDepth) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, extent[0], extent[1]);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(bytes).unwrap();
    writer.finish().unwrap();
    file
}

fn exr_of(channels: Vec<(&str, FlatSamples)>, extent: [usize; 2]) -> Vec<u8> {
    let list: SmallVec<[AnyChannel<FlatSamples>; 4]> =
        channels.into_iter().map(|(name, samples)| AnyChannel::new(Text::from(name), samples)).collect();
    let layer = Layer::new(
        (extent[0], extent[1]),
        LayerAttributes::default(),
        ::exr::prelude::Encoding::UNCOMPRESSED,
        AnyChannels::sort(list),
    );
    let mut file = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut file).unwrap();
    file.into_inner()
}

fn read(path: &str, bytes: &[u8], request: &ImageRequest) -> Result<FileImage, Refusal> {
    let files = MemoryFiles::default();
    files.insert(path, bytes);
    let contents = FileSources::default().read(&files, path, Some(request))?;
    match &*contents {
        FileContents::Image(image) => Ok(image.clone()),
        FileContents::Bytes(_) => panic!("it was asked for as an image"),
    }
}

fn plain() -> ImageRequest {
    ImageRequest { mips: 1, ..ImageRequest::default() }
}

#[test]
fn png_has_the_format_of_its_channels() {
    let grey = png(&[0, 128, 255, 7], [2, 2], ColorType::Grayscale);
    let image = read("a.png", &grey, &plain()).unwrap();
    assert_eq!((image.format, image.extent, image.volume), (Format::R8, [2, 2, 1], false));
    assert_eq!(image.mips, [[0, 128, 255, 7]]);

    // Three channels become four, opaque.
    let colour = png(&[1, 2, 3, 4, 5, 6], [2, 1], ColorType::Rgb);
    let image = read("a.png", &colour, &plain()).unwrap();
    assert_eq!((image.format, &image.mips[0]), (Format::Rgba8, &vec![1, 2, 3, 255, 4, 5, 6, 255]));

    let deep: Vec<u8> = [0_u16, 65535, 300, 40000].iter().flat_map(|value| value.to_be_bytes()).collect();
    let deep = png_of(&deep, [2, 1], ColorType::GrayscaleAlpha, BitDepth::Sixteen);
    let image = read("a.PNG", &deep, &plain()).unwrap();
    let stored: Vec<u8> = [0_u16, 65535, 300, 40000].iter().flat_map(|value| value.to_le_bytes()).collect();
    assert_eq!((image.format, &image.mips[0]), (Format::Rg16, &stored));
}

#[test]
fn a_wider_format_holds_the_same_numbers() {
    let grey = png(&[0, 51, 255], [3, 1], ColorType::Grayscale);
    let of = |format| {
        let request = ImageRequest { format: Some(format), ..plain() };
        read("a.png", &grey, &request).unwrap().mips.remove(0)
    };
    assert_eq!(of(Format::R8ui), [0, 51, 255]);
    assert_eq!(of(Format::R16), [0_u16, 13107, 65535].map(u16::to_le_bytes).concat());
    assert_eq!(of(Format::R32f), [0.0_f32, 0.2, 1.0].map(f32::to_le_bytes).concat());
    assert_eq!(of(Format::R32ui), [0_u32, 51, 255].map(u32::to_le_bytes).concat());
    for wrong in [Format::Rg8, Format::R8Snorm, Format::R32i, Format::Rgba8] {
        let refused = read("a.png", &grey, &ImageRequest { format: Some(wrong), ..plain() }).unwrap_err();
        assert_eq!((refused.key, refused.code), ("format", codes::graph::FILE_SOURCE));
    }
    let deep = png_of(&[0, 1], [1, 1], ColorType::Grayscale, BitDepth::Sixteen);
    assert!(read("a.png", &deep, &ImageRequest { format: Some(Format::R8), ..plain() }).is_err());
}

#[test]
fn srgb_is_brought_into_linear_light_and_alpha_is_not() {
    let colour = png(&[188, 0, 255, 128], [1, 1], ColorType::Rgba);
    let image = read("a.png", &colour, &ImageRequest { srgb: true, ..plain() }).unwrap();
    assert_eq!(image.format, Format::Rgba16f);
    let values = [0, 1, 2, 3].map(|channel| Channel::Half.get(&image.mips[0], channel));
    for (value, expected) in values.into_iter().zip([0.5029, 0.0, 1.0, 128.0 / 255.0]) {
        assert!((value - expected).abs() < 5e-4, "{values:?}");
    }
    // Eight bits are too few for linear light.
    let narrow = ImageRequest { srgb: true, format: Some(Format::Rgba8), ..plain() };
    assert_eq!(read("a.png", &colour, &narrow).unwrap_err().key, "format");
    // Black and white side by side are half the light, not half the number.
    let pair = png(&[0, 255], [2, 1], ColorType::Grayscale);
    let mip = |srgb| read("a.png", &pair, &ImageRequest { srgb, mips: 0, ..plain() }).unwrap().mips.remove(1);
    assert_eq!(mip(false), [128]);
    assert_eq!(mip(true), half::f16::from_f32(0.5).to_le_bytes());
}

#[test]
fn a_strip_becomes_slices() {
    let strip = png(&[1, 2, 3, 4, 5, 6, 7, 8], [2, 4], ColorType::Grayscale);
    let request = ImageRequest { slices: Some(2), mips: 0, ..plain() };
    let image = read("a.png", &strip, &request).unwrap();
    assert_eq!((image.extent, image.volume), ([2, 2, 2], true));
    // The mean of 1 to 8, with half a step rounded up.
    assert_eq!(image.mips, [vec![1, 2, 3, 4, 5, 6, 7, 8], vec![5]]);
    let refused = read("a.png", &strip, &ImageRequest { slices: Some(3), ..request }).unwrap_err();
    assert_eq!(refused.key, "slices");
}

#[test]
fn exr_keeps_its_numbers() {
    let reds = FlatSamples::F32(vec![1.5, -2.0]);
    let image = read("a.exr", &exr_of(vec![("Y", reds)], [2, 1]), &plain()).unwrap();
    assert_eq!((image.format, image.extent), (Format::R32f, [2, 1, 1]));
    assert_eq!(image.mips[0], [1.5_f32, -2.0].map(f32::to_le_bytes).concat());

    let half = |value: f32| FlatSamples::F16(vec![f16::from_f32(value)]);
    let file = exr_of(vec![("B", half(3.0)), ("R", half(1.0)), ("G", half(2.0))], [1, 1]);
    let image = read("a.exr", &file, &plain()).unwrap();
    assert_eq!(image.format, Format::Rgba16f);
    assert_eq!(image.mips[0], [1.0, 2.0, 3.0, 1.0].map(|value| f16::from_f32(value).to_le_bytes()).concat());

    let ids = exr_of(vec![("id", FlatSamples::U32(vec![7, u32::MAX]))], [2, 1]);
    assert_eq!(read("a.exr", &ids, &plain()).unwrap().mips[0], [7, u32::MAX].map(u32::to_le_bytes).concat());
    assert_eq!(read("a.exr", &ids, &ImageRequest { mips: 2, ..plain() }).unwrap_err().key, "mips");

    let odd = exr_of(vec![("U", half(0.0)), ("V", half(0.0))], [1, 1]);
    let refused = read("a.exr", &odd, &plain()).unwrap_err();
    assert!(refused.message.contains("U, V"), "{}", refused.message);
    assert_eq!(read("a.exr", &file, &ImageRequest { srgb: true, ..plain() }).unwrap_err().key, "encoding");
}

#[test]
fn what_is_damaged_or_too_large_is_refused() {
    let whole = png(&[9; 64 * 64], [64, 64], ColorType::Grayscale);
    let float = exr_of(vec![("Y", FlatSamples::F32(vec![0.5; 64 * 64]))], [64, 64]);
    for (path, whole) in [("a.png", &whole), ("a.exr", &float)] {
        assert!(read(path, whole, &plain()).is_ok());
        for length in (0..whole.len() - 16).step_by(7) {
            let refused = read(path, &whole[..length], &plain());
            assert!(refused.is_err_and(|refused| refused.message.contains(path)), "{path}, {length} bytes");
        }
        for at in 0..whole.len().min(600) {
            let mut broken = whole.clone();
            broken[at] ^= 0x55;
            // Right or wrong, it ends.
            let _ = read(path, &broken, &plain());
        }
    }
    // A header that promises 4 GiB of texels.
    let mut huge = png(&[0; 4], [2, 2], ColorType::Grayscale);
    huge[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
    assert!(read("a.png", &huge, &plain()).is_err());
    assert_eq!(read("a.jpg", &whole, &plain()).unwrap_err().key, "source");
    assert_eq!(read("a.png", &whole, &ImageRequest { mips: 8, ..plain() }).unwrap_err().key, "mips");
}

#[test]
fn bytes_are_padded_and_decoded_once() {
    let files = MemoryFiles::default();
    files.insert("a.bin", vec![1_u8, 2, 3, 4, 5]);
    files.insert("empty.bin", Vec::<u8>::new());
    let sources = FileSources::default();
    let first = sources.read(&files, "a.bin", None).unwrap();
    assert_eq!(*first, FileContents::Bytes(vec![1, 2, 3, 4, 5, 0, 0, 0]));
    assert!(Arc::ptr_eq(&first, &sources.read(&files, "a.bin", None).unwrap()));
    files.insert("a.bin", vec![1_u8]);
    assert_eq!(*sources.read(&files, "a.bin", None).unwrap(), FileContents::Bytes(vec![1, 0, 0, 0]));
    assert!(sources.read(&files, "empty.bin", None).is_err());
    assert_eq!(sources.read(&files, "none.bin", None).unwrap_err().code, codes::files::NOT_FOUND);
}

#[test]
fn a_header_that_promises_more_than_the_file_holds_is_refused_before_anything_is_allocated() {
    let mut file = png(&vec![0; 4096 * 4096], [4096, 4096], ColorType::Grayscale);
    file.truncate(100);
    let refused = read("a.png", &file, &plain()).unwrap_err();
    let message =
        "`a.png` cannot be read: it is damaged: its header promises 16781312 bytes of pixels, and it has 100 bytes";
    assert_eq!(refused.message, message);
}
