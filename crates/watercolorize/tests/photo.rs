//! A photograph becomes mattes, and mattes, pigments and the photograph become a painting, without help.

use std::io::Cursor;

use girtin_grid::Raster;
use girtin_optics::{Lab, LinearRgb};
use girtin_painting::document::SheetSettings;
use girtin_painting::picture::{PictureLimits, read_photo};
use girtin_painting::{PaintConfig, Stock};
use girtin_watercolorize::c97::{C97Config, C97Request, GlazesFile, watercolorize_c97};
use girtin_watercolorize::mattes::{MattesParams, mattes};

fn photo(bytes: &[u8]) -> Raster<LinearRgb> {
    read_photo(Cursor::new(bytes), None, &PictureLimits::default(), LinearRgb::WHITE)
        .unwrap()
        .pixels
        .map(|color| LinearRgb(color.map(f64::from)))
}

#[test]
fn what_a_person_tells_apart_is_in_mattes_of_its_own() {
    let photo = photo(include_bytes!("photos/astronaut-collar.png"));
    let mattes = mattes(&photo, &MattesParams::default());
    assert!((3..=12).contains(&mattes.len()), "{}", mattes.len());
    let at = |x: usize, y: usize| {
        let most =
            mattes.iter().enumerate().max_by(|a, b| a.1.coverage.at(x, y).total_cmp(&b.1.coverage.at(x, y)));
        most.unwrap().0
    };
    let (ground, flag, collar, hair) = (at(60, 60), at(15, 185), at(115, 150), at(110, 60));
    assert_eq!(ground, at(30, 20), "the ground is one");
    let mut all = [ground, flag, collar, hair];
    all.sort_unstable();
    assert!(all.windows(2).all(|pair| pair[0] != pair[1]), "ground, flag, collar and hair: {all:?}");
    assert!(mattes[flag].name.ends_with("red"), "{}", mattes[flag].name);
    assert!(mattes[collar].name.ends_with("black"), "{}", mattes[collar].name);
}

/// Means of blocks of ten pixels: what one sees from afar.
fn from_afar(picture: &Raster<LinearRgb>) -> Vec<Lab> {
    let block = |number: usize| {
        let (column, row) = (number % (picture.width() / 10), number / (picture.width() / 10));
        let mut sum = [0.0; 3];
        for y in 0..10 {
            for x in 0..10 {
                let color = picture.at(10 * column + x, 10 * row + y);
                sum.iter_mut().zip(color.0).for_each(|(sum, channel)| *sum += channel / 100.0);
            }
        }
        LinearRgb(sum).to_lab()
    };
    (0..(picture.width() / 10) * (picture.height() / 10)).map(block).collect()
}

#[test]
fn a_photograph_is_painted_from_its_own_mattes() {
    let photo = photo(include_bytes!("photos/chelsea-eye.png"));
    let mattes = mattes(&photo, &MattesParams { regions: 5, ..MattesParams::default() });
    let mut text = "format = 1\n".to_owned();
    for matte in &mattes {
        let pigments = "['hansa-yellow', 'indian-red', 'french-ultramarine']";
        text += &format!("[[matte]]\nname = '{}'\npigments = {pigments}\n", matte.name);
    }
    let stock = Stock::builtin();
    let glazes = GlazesFile::from_toml("glazes.toml", &text, &stock).unwrap();
    let sheet = SheetSettings {
        size_mm: [27.5, 22.5],
        paper: "cold-press".to_owned(),
        seed: 1,
        ground: LinearRgb::WHITE,
        printed: Vec::new(),
        pixels_per_mm: 4.0,
        cells_per_pixel: 1,
        cells_per_mm: None,
        trim_mm: 0.0,
        relief_mm: 0.0,
    };
    let request = C97Request {
        title: "Chelsea",
        picture: &photo,
        mattes: &mattes,
        glazes: &glazes,
        sheet: &sheet,
        stock: &stock,
    };
    let planned = watercolorize_c97(&request, &C97Config::default()).unwrap();
    let painted = planned.document.paint(&stock, &planned.maps, &PaintConfig::default()).unwrap();
    let (wanted, found) = (from_afar(&photo), from_afar(&painted.picture()));
    let off = |a: &Lab, b: &Lab| ((a.l - b.l).powi(2) + (a.a - b.a).powi(2) + (a.b - b.b).powi(2)).sqrt();
    let mean = wanted.iter().zip(&found).map(|(a, b)| off(a, b)).sum::<f64>() / wanted.len() as f64;
    let paper = LinearRgb::WHITE.to_lab();
    let bare = wanted.iter().map(|a| off(a, &paper)).sum::<f64>() / wanted.len() as f64;
    assert!(mean < 14.0 && mean < 0.3 * bare, "{mean} off, {bare} for bare paper");
}
