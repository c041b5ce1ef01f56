use std::io::{Cursor, Read};

use proptest::prelude::*;
use zip::{CompressionMethod, ZipArchive};

use super::*;

const SIZE: (usize, usize) = (7, 5);

fn paper() -> Raster<[u8; 3]> {
    Raster::from_fn(SIZE.0, SIZE.1, |x, y| [250 - x as u8, 245, 240 - y as u8])
}

/// Pictures after two glazes that darken, the second in one half only.
fn glazed() -> [Raster<[u8; 3]>; 2] {
    let first = Raster::from_fn(SIZE.0, SIZE.1, |x, y| [200 - 9 * x as u8, 180, 30 + y as u8]);
    let second = Raster::from_fn(SIZE.0, SIZE.1, |x, y| {
        let [r, g, b] = first.at(x, y);
        if x < 4 { [r, g, b] } else { [r / 2, g - 77, b - 20] }
    });
    [first, second]
}

fn opaque(picture: &Raster<[u8; 3]>) -> Raster<[u8; 4]> {
    picture.map(|[r, g, b]| [r, g, b, 255])
}

/// A file of paper and two glazes, and what was laid.
fn written(name: &str) -> Vec<u8> {
    let mut glazes = GlazeLayers::new(paper());
    let mut file = Cursor::new(Vec::new());
    let mut ora = OraFile::begin(&mut file, SIZE, Some(11.811)).unwrap();
    let mut add = |name, pixels, composite| {
        ora.layer(&OraLayer { name, pixels: &pixels, composite, opacity: 1.0 }).unwrap();
    };
    add("paper", opaque(&paper()), Composite::Over);
    for after in &glazed() {
        add(name, glazes.lay(after), Composite::Multiply);
    }
    ora.end(&glazed()[1]).unwrap();
    file.into_inner()
}

fn entry(archive: &mut ZipArchive<Cursor<Vec<u8>>>, name: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    archive.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
    bytes
}

/// The values of an attribute, in order.
fn attributes<'a>(xml: &'a str, name: &str) -> Vec<&'a str> {
    let mark = format!(" {name}=\"");
    xml.split(&mark).skip(1).map(|after| after.split('"').next().unwrap()).collect()
}

/// Multiplies as GIMP and Krita do on 8 bits, with coverage; another formula than the writer's.
fn flatten(layers: &[(image::RgbaImage, bool)]) -> image::RgbImage {
    let mut canvas = image::RgbImage::new(SIZE.0 as u32, SIZE.1 as u32);
    for (layer, multiplies) in layers {
        for (below, pixel) in canvas.pixels_mut().zip(layer.pixels()) {
            let alpha = f64::from(pixel.0[3]) / 255.0;
            for (below, &value) in below.0.iter_mut().zip(&pixel.0) {
                let (b, l) = (f64::from(*below), f64::from(value));
                let laid = if *multiplies { b * l / 255.0 } else { l };
                *below = (b + alpha * (laid - b)).round() as u8;
            }
        }
    }
    canvas
}

#[test]
fn the_archive_is_as_the_standard_says() {
    let bytes = written("a <b> & \"c\"\n");
    assert_eq!(&bytes[30..54], b"mimetypeimage/openraster");
    let mut archive = ZipArchive::new(Cursor::new(bytes)).unwrap();
    let first = archive.by_index(0).unwrap();
    assert_eq!(first.name().unwrap(), "mimetype");
    assert_eq!(first.compression(), CompressionMethod::Stored);
    drop(first);
    let xml = String::from_utf8(entry(&mut archive, "stack.xml")).unwrap();
    assert_eq!(attributes(&xml, "w"), ["7"]);
    assert_eq!(attributes(&xml, "h"), ["5"]);
    assert_eq!(attributes(&xml, "xres"), ["300"]);
    assert_eq!(attributes(&xml, "yres"), ["300"]);
    // The highest first.
    let name = "a &lt;b&gt; &amp; &quot;c&quot; ";
    assert_eq!(attributes(&xml, "name"), [name, name, "paper"]);
    assert_eq!(attributes(&xml, "composite-op"), ["svg:multiply", "svg:multiply", "svg:src-over"]);
    assert_eq!(xml.matches('<').count(), xml.matches('>').count());
    for source in attributes(&xml, "src") {
        let layer = image::load_from_memory(&entry(&mut archive, source)).unwrap();
        assert_eq!((layer.width(), layer.height()), (7, 5));
    }
    let merged = image::load_from_memory(&entry(&mut archive, "mergedimage.png")).unwrap().into_rgb8();
    assert_eq!(merged.as_raw(), glazed()[1].as_slice().as_flattened());
    assert!(image::load_from_memory(&entry(&mut archive, "Thumbnails/thumbnail.png")).is_ok());
}

#[test]
fn equal_layers_give_equal_bytes() {
    assert_eq!(written("glaze"), written("glaze"));
}

#[test]
fn the_layers_of_a_file_multiply_to_the_painting() {
    let mut archive = ZipArchive::new(Cursor::new(written("glaze"))).unwrap();
    let xml = String::from_utf8(entry(&mut archive, "stack.xml")).unwrap();
    let modes = attributes(&xml, "composite-op");
    let mut layers = Vec::new();
    for (source, mode) in attributes(&xml, "src").into_iter().zip(modes).rev() {
        let layer = image::load_from_memory(&entry(&mut archive, source)).unwrap().into_rgba8();
        layers.push((layer, mode == "svg:multiply"));
    }
    let flat = flatten(&layers);
    assert_eq!(flat.as_raw(), glazed()[1].as_slice().as_flattened());
    // Where the second glaze changed nothing, its layer is transparent.
    assert_eq!(layers[2].0.get_pixel(0, 0).0[3], 0);
    assert_eq!(layers[2].0.get_pixel(5, 0).0[3], 255);
}

#[test]
fn what_a_glaze_lightens_is_told() {
    let mut glazes = GlazeLayers::new(Raster::new(2, 1, [100; 3]));
    glazes.lay(&Raster::from_fn(2, 1, |x, _| if x == 0 { [112, 50, 50] } else { [100, 0, 100] }));
    let painting = Raster::from_fn(2, 1, |x, _| if x == 0 { [112, 50, 50] } else { [100, 0, 100] });
    assert_eq!(glazes.difference(&painting), Difference { mean: 2.0, max: 12 });
    assert_eq!(glazes.flattened().at(1, 0), [100, 0, 100]);
    // Black cannot become anything else.
    assert_eq!(part(0, 0.0, 0), 255);
    assert_eq!(part(0, 0.0, 9), 255);
}

#[test]
fn what_a_later_glaze_lightens_is_lightened_before() {
    let [first, second] = glazed();
    let last = Raster::from_fn(SIZE.0, SIZE.1, |x, y| if x == 6 { [240, 200, 99] } else { second.at(x, y) });
    let mut pictures = [paper(), first.clone(), second.clone(), last.clone()];
    GlazeLayers::lighten(&mut pictures);
    let mut glazes = GlazeLayers::new(pictures[0].clone());
    pictures[1..].iter().for_each(|picture| drop(glazes.lay(picture)));
    assert!(glazes.difference(&last).max <= 1, "{:?}", glazes.difference(&last));
    assert_eq!(pictures[1].at(2, 2), first.at(2, 2), "elsewhere nothing changes");
    assert_eq!(pictures[3], last);
}

#[test]
fn every_darker_value_is_met() {
    for below in 0..=255u8 {
        for after in 0..=below {
            assert_eq!(multiplied(below, part(below, f32::from(below), after)), after, "{after} of {below}");
        }
    }
}

#[test]
fn a_thumbnail_is_small_and_of_the_same_light() {
    let checks = Raster::from_fn(1024, 300, |x, y| if (x + y) % 2 == 0 { [255; 3] } else { [0; 3] });
    let small = thumbnail(&checks);
    assert_eq!((small.width(), small.height()), (256, 75));
    // Half of the light is 188 encoded, not 128.
    assert!(small.as_slice().iter().all(|&pixel| pixel == [188; 3]));
    assert_eq!(thumbnail(&paper()), paper());
    assert_eq!(thumbnail(&Raster::new(9000, 1, [7; 3])), Raster::new(256, 1, [7; 3]));
}

#[test]
fn other_sizes_are_refused() {
    let mut ora = OraFile::begin(Cursor::new(Vec::new()), SIZE, None).unwrap();
    let pixels = Raster::new(5, 7, [0; 4]);
    let layer = OraLayer { name: "", pixels: &pixels, composite: Composite::Over, opacity: 1.0 };
    assert!(matches!(ora.layer(&layer), Err(WriteError::Parts { .. })));
    assert!(matches!(ora.end(&Raster::new(5, 7, [0; 3])), Err(WriteError::Parts { .. })));
}

#[test]
fn a_full_disk_is_an_error() {
    let pixels = opaque(&paper());
    let write = |disk: Cursor<&mut [u8]>| -> Result<(), WriteError> {
        let mut ora = OraFile::begin(disk, SIZE, None)?;
        for _ in 0..3 {
            ora.layer(&OraLayer {
                name: "glaze",
                pixels: &pixels,
                composite: Composite::Over,
                opacity: 1.0,
            })?;
        }
        ora.end(&paper())
    };
    let needed = (0..).find(|&room| match write(Cursor::new(&mut vec![0; room])) {
        Ok(()) => true,
        Err(WriteError::Write(_)) => false,
        Err(error) => panic!("{room}: {error}"),
    });
    assert!(needed.unwrap() > 1000);
}

proptest! {
    #[test]
    fn glazes_that_darken_are_met_however_they_are_put_together(
        paper in prop::collection::vec(any::<[u8; 3]>(), 1..40),
        parts in prop::collection::vec(any::<[u8; 3]>(), 1..120),
    ) {
        let paper = Raster::from_vec(paper.len(), 1, paper).unwrap();
        let mut glazes = GlazeLayers::new(paper.clone());
        let mut product = paper.map(|color| color.map(f64::from));
        let mut picture = paper;
        for parts in parts.chunks(picture.width()) {
            picture = Raster::from_fn(picture.width(), 1, |x, _| {
                let part = parts.get(x).copied().unwrap_or([255; 3]);
                std::array::from_fn(|i| (u32::from(picture.at(x, 0)[i]) * u32::from(part[i]) / 255) as u8)
            });
            let layer = glazes.lay(&picture);
            product = Raster::from_fn(picture.width(), 1, |x, _| {
                let [r, g, b, coverage] = layer.at(x, 0);
                let part = if coverage == 0 { [255; 3] } else { [r, g, b] };
                std::array::from_fn(|i| product.at(x, 0)[i] * f64::from(part[i]) / 255.0)
            });
        }
        prop_assert!(glazes.difference(&picture).max <= 1, "{:?}", glazes.difference(&picture));
        for (found, wanted) in product.as_slice().as_flattened().iter().zip(picture.as_slice().as_flattened()) {
            prop_assert!((found - f64::from(*wanted)).abs() <= 1.0, "{} is not {}", found, wanted);
        }
    }
}
