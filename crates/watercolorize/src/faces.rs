//! Faces: what everybody looks at first, and what bears no stray mark.

use std::io::Cursor;

use girtin_grid::Raster;
use girtin_grid::resize::resized_plane;
use rustface::{ImageData, create_detector_with_model, read_model};

use crate::accidents::smoothstep;
use crate::study::Plane;

/// The SeetaFace engine's model of faces seen from the front; its license lies beside it.
const MODEL: &[u8] = include_bytes!("../model/seeta_fd_frontal_v1.0.bin");

/// Pixels along the long edge of the picture that faces are looked for in.
const LOOKED_AT: f64 = 960.0;
/// Pixels along the short edge that the detector needs: its window.
const WINDOW: usize = 40;
/// Score from which on a find is a face; the engine's authors use 0.95, 2.8 and 4.5.
const SCORE: f64 = 4.5;
/// Steps of the window, pixels, and of the picture's size.
const STEP: u32 = 4;
const SCALE: f32 = 0.8;

/// Half the size of a head, parts of what the detector marks, brows to chin; and where it ends, parts of that.
const HEAD: [f32; 2] = [0.66, 0.82];
const END: [f32; 2] = [0.85, 1.3];

/// Shoulders and chest: how far below the head's middle, and half their size, in half heads; and how exact they are.
const BELOW: f32 = 3.0;
const CHEST: [f32; 2] = [2.9, 2.9];
const FIGURE: f32 = 0.5;

/// A face: its middle and half its head's size, parts of the picture's width and height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    middle: [f32; 2],
    half: [f32; 2],
}

/// The faces in a picture's lightness, Lab.
pub fn faces(lightness: &Plane) -> Vec<Face> {
    let size = [lightness.width(), lightness.height()];
    let scale = (LOOKED_AT / size[0].max(size[1]) as f64).min(1.0);
    let [width, height] = size.map(|cells| libm::round(scale * cells as f64) as usize);
    if width.min(height) < WINDOW {
        return Vec::new();
    }
    let picture = resized_plane(lightness, width, height);
    let gray: Vec<u8> = picture.as_slice().iter().map(|l| (2.55 * l).clamp(0.0, 255.0) as u8).collect();
    let model = read_model(Cursor::new(MODEL)).unwrap_or_else(|_| unreachable!("the model is whole"));
    let mut detector = create_detector_with_model(model);
    detector.set_score_thresh(SCORE);
    detector.set_slide_window_step(STEP, STEP);
    detector.set_pyramid_scale_factor(SCALE);
    let found = detector.detect(&ImageData::new(&gray, width as u32, height as u32));
    let face = |found: &rustface::FaceInfo| {
        let marked = found.bbox();
        let [wide, high] = [marked.width(), marked.height()].map(|pixels| pixels as f32);
        let middle = [marked.x() as f32 + 0.5 * wide, marked.y() as f32 + 0.45 * high];
        let of_picture = |pixels: [f32; 2]| [pixels[0] / width as f32, pixels[1] / height as f32];
        Face { middle: of_picture(middle), half: of_picture([HEAD[0] * wide, HEAD[1] * high]) }
    };
    found.iter().map(face).collect()
}

/// How much of each cell is part of a head, 0 to 1.
pub fn in_heads(faces: &[Face], size: [usize; 2]) -> Plane {
    within(faces, size, 0.0)
}

/// How exactly each cell is drawn as part of a face, 1, or of the figure below it, less.
pub fn in_figures(faces: &[Face], size: [usize; 2]) -> Plane {
    within(faces, size, FIGURE)
}

fn within(faces: &[Face], [width, height]: [usize; 2], figure: f32) -> Plane {
    Raster::by_rows(width, height, |x, y| {
        let cell = [(x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32];
        let inside = faces.iter().map(|face| {
            let [off, up] = [0, 1].map(|k: usize| (cell[k] - face.middle[k]) / face.half[k]);
            let within = |off: f32, up: f32| 1.0 - smoothstep(libm::hypotf(off, up), END[0], END[1]);
            within(off, up).max(figure * within(off / CHEST[0], (up - BELOW) / CHEST[1]))
        });
        inside.fold(0.0, f32::max)
    })
}

#[cfg(test)]
mod tests {
    use girtin_optics::LinearRgb;
    use girtin_painting::picture::{PictureLimits, read_photo};

    use super::*;

    fn lightness(bytes: &[u8]) -> Plane {
        let photo =
            read_photo(Cursor::new(bytes), None, &PictureLimits::default(), LinearRgb::WHITE).unwrap();
        photo.pixels.map(|color| LinearRgb(color.map(f64::from)).to_lab().l as f32)
    }

    #[test]
    fn a_person_s_face_is_found_and_no_cat_s_eye() {
        let [woman, eye] = [
            &include_bytes!("../tests/photos/astronaut-face.png")[..],
            include_bytes!("../tests/photos/chelsea-eye.png"),
        ]
        .map(|bytes| faces(&lightness(bytes)));
        assert_eq!(eye, []);
        let [face] = woman[..] else { panic!("{woman:?}") };
        let [x, y] = face.middle;
        assert!((x - 0.5).abs() < 0.08 && (y - 0.44).abs() < 0.08, "{face:?}");
        assert!((0.25..0.45).contains(&face.half[0]), "{face:?}");
    }

    #[test]
    fn whatever_is_looked_at_is_no_panic_and_no_face() {
        for [width, height] in [[1, 1], [5000, 1], [39, 200], [40, 40], [41, 900], [300, 200]] {
            let checks =
                Raster::from_fn(width, height, |x, y| if (x / 7 + y / 5) % 2 == 0 { 100.0 } else { 0.0 });
            for picture in [checks, Raster::new(width, height, 50.0)] {
                assert_eq!(faces(&picture), [], "{width} × {height}");
            }
        }
    }

    #[test]
    fn a_face_is_a_soft_ellipse_above_a_less_exact_figure() {
        let face = Face { middle: [0.5, 0.2], half: [0.1, 0.15] };
        let exact = in_figures(&[face], [100, 100]);
        assert_eq!((exact.at(50, 20), exact.at(50, 30), exact.at(95, 20)), (1.0, 1.0, 0.0));
        let edge = exact.at(60, 20);
        assert!(0.0 < edge && edge < 1.0, "{edge}");
        assert_eq!((exact.at(50, 60), exact.at(40, 70), exact.at(5, 60)), (FIGURE, FIGURE, 0.0));
    }
}
