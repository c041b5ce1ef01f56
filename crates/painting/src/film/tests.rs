use std::io::{self, Cursor};

use image::AnimationDecoder;
use image::codecs::gif::GifDecoder;
use image::codecs::png::PngDecoder;

use super::*;

const FORMATS: [FilmFormat; 2] = [FilmFormat::Apng, FilmFormat::Gif];

fn plan(format: FilmFormat, frames: u32, frames_per_second: u16) -> FilmPlan {
    FilmPlan { size: (19, 11), frames, frames_per_second, format, meta: PictureMeta::default() }
}

/// White, then a growing square of few colors, then twice the same.
fn frames() -> Vec<Raster<[u8; 3]>> {
    let frame = |side: usize| {
        Raster::from_fn(19, 11, |x, y| {
            if (4..4 + side).contains(&x) && (3..3 + side).contains(&y) { [x as u8, 9, 99] } else { [250; 3] }
        })
    };
    [0, 1, 5, 8, 8].map(frame).to_vec()
}

fn written(format: FilmFormat, frames: &[Raster<[u8; 3]>], rate: u16) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut film = Film::begin(&mut bytes, plan(format, frames.len() as u32, rate)).unwrap();
    frames.iter().for_each(|frame| film.frame(frame).unwrap());
    film.end().unwrap();
    bytes
}

fn read(format: FilmFormat, bytes: &[u8]) -> Vec<image::Frame> {
    let frames = match format {
        FilmFormat::Apng => PngDecoder::new(Cursor::new(bytes)).unwrap().apng().unwrap().into_frames(),
        FilmFormat::Gif => GifDecoder::new(Cursor::new(bytes)).unwrap().into_frames(),
    };
    frames.collect_frames().unwrap()
}

#[test]
fn every_frame_comes_back_as_it_was() {
    for format in FORMATS {
        let bytes = written(format, &frames(), 10);
        let found = read(format, &bytes);
        assert_eq!(found.len(), 5);
        for (found, wanted) in found.iter().zip(frames()) {
            assert_eq!(found.delay().numer_denom_ms(), (100, 1));
            let colors = found.buffer().pixels().map(|pixel| [pixel.0[0], pixel.0[1], pixel.0[2]]);
            assert!(colors.eq(wanted.as_slice().iter().copied()), "{format:?}");
        }
        assert_eq!(bytes, written(format, &frames(), 10));
    }
}

#[test]
fn only_changes_are_written() {
    let still = vec![frames()[3].clone(); 40];
    let moving = [still.clone(), frames()].concat();
    for format in FORMATS {
        let (one, all) = (written(format, &still[..1], 25), written(format, &still, 25));
        assert!(all.len() < one.len() + 40 * 110, "{format:?}: {} after {}", all.len(), one.len());
        assert_eq!(read(format, &written(format, &moving, 25)).len(), 45);
    }
    let [before, after] = [frames()[1].clone(), frames()[2].clone()];
    assert_eq!(changed(&before, &after), [4..9, 3..8]);
    assert_eq!(changed(&after, &after), [0..1, 0..1]);
}

#[test]
fn a_gif_of_many_colors_is_near() {
    let frame = Raster::from_fn(64, 64, |x, y| [4 * x as u8, 4 * y as u8, (x + y) as u8]);
    let plan = FilmPlan { size: (64, 64), ..plan(FilmFormat::Gif, 1, 5) };
    let mut bytes = Vec::new();
    let mut film = Film::begin(&mut bytes, plan).unwrap();
    film.frame(&frame).unwrap();
    film.end().unwrap();
    let found = read(FilmFormat::Gif, &bytes);
    let pairs = found[0].buffer().pixels().zip(frame.as_slice());
    let apart =
        pairs.flat_map(|(found, wanted)| [0, 1, 2].map(|i| u32::from(found.0[i].abs_diff(wanted[i]))));
    let mean = f64::from(apart.sum::<u32>()) / (3.0 * 64.0 * 64.0);
    assert!(mean < 12.0, "{mean}");
}

#[test]
fn time_is_kept_over_many_frames() {
    for rate in 1..=FASTEST {
        for second in 0..3 {
            let frames = second * u32::from(rate)..(second + 1) * u32::from(rate);
            let delays: Vec<u16> = frames.map(|frame| hundredths(frame, rate)).collect();
            assert_eq!(delays.iter().sum::<u16>(), 100, "{rate}: {delays:?}");
            assert!(delays.iter().all(|&delay| delay >= 2));
        }
    }
}

#[test]
fn what_was_not_announced_is_refused() {
    for format in FORMATS {
        for (frames, rate) in [(0, 10), (5, 0), (5, 51)] {
            let film = Film::begin(io::sink(), plan(format, frames, rate));
            assert!(matches!(film, Err(WriteError::Parts { .. })));
        }
        let mut film = Film::begin(io::sink(), plan(format, 1, 10)).unwrap();
        let error = film.frame(&Raster::new(11, 19, [0; 3])).unwrap_err();
        assert_eq!(error.to_string(), "there are 11 × 19 pixels, not 19 × 11 pixels");
        film.frame(&frames()[0]).unwrap();
        let error = film.frame(&frames()[0]).unwrap_err();
        assert_eq!(error.to_string(), "there are 2 frames, not 1 frames");
        film.end().unwrap();
        let film = Film::begin(io::sink(), plan(format, 2, 10)).unwrap();
        assert!(matches!(film.end(), Err(WriteError::Parts { .. })));
    }
    let wide = FilmPlan { size: (70_000, 1), ..plan(FilmFormat::Gif, 1, 1) };
    assert!(matches!(Film::begin(io::sink(), wide), Err(WriteError::Size { .. })));
}

#[test]
fn a_full_disk_is_an_error() {
    for format in FORMATS {
        let whole = written(format, &frames(), 10).len();
        for room in 0..whole {
            let mut disk = vec![0; room];
            let result = Film::begin(disk.as_mut_slice(), plan(format, 5, 10)).and_then(|mut film| {
                frames().iter().try_for_each(|frame| film.frame(frame))?;
                film.end()
            });
            assert!(matches!(result, Err(WriteError::Write(_))), "{format:?}, {room} of {whole}: {result:?}");
        }
    }
}
