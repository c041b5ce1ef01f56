use std::io::{Cursor, Write};

use girtin_grid::Raster;
use girtin_optics::{LinearRgb, Pigment};
use girtin_paper::Paper;
use proptest::prelude::*;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::*;
use crate::maps::StoredMap;
use crate::paint::PaintConfig;
use crate::picture::{read_photo, write_png};

const DOCUMENT_TEXT: &str = "format = 1\ntitle = \"Two shapes\"\n[sheet]\nsize = [12, 9]\npaper = 'felt'\nseed = 5\n\
    pixels_per_mm = 6\ncells_per_mm = 4\ntrim = 0.5\nground = { linear = [0.9, 0.85, 0.8] }\n\
    [[glaze]]\nname = 'shapes'\npigments = ['mud', 'cobalt-blue']\n[glaze.outline]\nregions = 'regions'\n\
    edges = 'deep/edges'\n[[glaze.events]]\ndo = 'brush'\nwater = 0.6\namounts = [0.4, 0.2]\n\
    [[glaze.events]]\ndo = 'run'\nsteps = 60\nuntil = 'dry'\n[[glaze.events]]\ndo = 'lift'\nfraction = 0.5\n\
    area = { shape = 'disc', center = [3, 3], radius = 1 }\n";

const MUD: &str = "id = \"mud\"\nlabel = \"Mud\"\ndensity = 0.05\nstaining_power = 2\ngranulation = 0.5\n\
    [appearance]\nover_white = \"#996633\"\nover_black = \"#110c08\"\n";

const FELT: &str = "id = \"felt\"\nlabel = \"Felt\"\n[[tooth]]\nwavelength_mm = 0.8\n";

/// A painting with a pigment and a paper of its own and two maps, unpainted.
fn unpainted() -> GirtinFile {
    let mut stock = Stock::builtin();
    stock.pigments = stock.pigments.with(Pigment::from_toml("mud.toml", MUD).unwrap());
    stock.papers.insert(Paper::from_toml("felt.toml", FELT).unwrap());
    let document = Document::from_toml("shapes.toml", DOCUMENT_TEXT, &stock).unwrap();
    let regions = Raster::from_fn(24, 18, |x, _| if x < 12 { 1 } else { 2 });
    let edges = Raster::from_fn(24, 18, |x, _| (257 * (8 + 16 * x.abs_diff(12))).min(65535) as u16);
    let mut maps = MapChest::default();
    maps.0.insert("regions".to_owned(), StoredMap::Bytes(regions));
    maps.0.insert("deep/edges".to_owned(), StoredMap::Words(edges));
    GirtinFile { document, maps, stock, painted: None }
}

fn picture_of(file: &GirtinFile) -> (Raster<[u8; 3]>, Vec<Vec<PigmentBalance>>) {
    let painted = file.document.paint(&file.stock, &file.maps, &PaintConfig::default()).unwrap();
    let picture = painted.development().encoded(|color| color.to_srgb().to_bytes());
    (picture, painted.glazes.into_iter().map(|glaze| glaze.pigments).collect())
}

fn painted() -> GirtinFile {
    let mut file = unpainted();
    let (picture, balances) = picture_of(&file);
    let mut merged = Vec::new();
    write_png(&mut merged, &picture, &PictureMeta::default()).unwrap();
    let thumbnail = thumbnail_png(&picture).unwrap();
    file.painted = Some(PaintedRecord { water: WaterDetail::Coarse, balances, merged, thumbnail });
    file
}

fn written(file: &GirtinFile) -> Vec<u8> {
    let mut bytes = Vec::new();
    file.write(&mut bytes).unwrap();
    bytes
}

fn read(bytes: &[u8]) -> Result<GirtinFile, GirtinFileError> {
    GirtinFile::read(Cursor::new(bytes), &Limits::default())
}

fn zip(entries: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

#[test]
fn a_painting_is_read_as_it_was_written() {
    let file = painted();
    let bytes = written(&file);
    assert!(bytes == written(&file), "the same bytes");
    assert!(is_girtin_file(Cursor::new(&bytes)).unwrap() && !is_girtin_file(Cursor::new(b"PK")).unwrap());
    assert!(is_girtin_file(Cursor::new(&bytes[..90])).unwrap(), "cut short");
    let packed_by_hand = zip(&[(DOCUMENT, b""), (MIMETYPE, b"")]);
    assert!(is_girtin_file(Cursor::new(packed_by_hand)).unwrap());
    // Where programs look for what a file is.
    assert!(bytes[30..].starts_with(format!("mimetype{MIME_TYPE}").as_bytes()));
    let again = read(&bytes).unwrap();
    assert_eq!((&again.document, &again.maps), (&file.document, &file.maps));
    assert_eq!(again.painted, file.painted);
    assert_eq!(again.document.fingerprint(&again.maps), file.document.fingerprint(&file.maps));
    assert!(picture_of(&again) == picture_of(&file), "with its own pigment and paper");
    assert!(bytes == written(&again), "read and written again");
    let unpainted = read(&written(&unpainted())).unwrap();
    assert_eq!(unpainted.painted, None);
}

#[test]
fn a_library_that_changes_changes_no_painting() {
    let file = read(&written(&painted())).unwrap();
    // Cobalt blue is built in, and kept nevertheless.
    let names: Vec<String> = {
        let zip = zip::ZipArchive::new(Cursor::new(written(&file))).unwrap();
        zip.file_names_raw().map(|name| String::from_utf8(name.to_vec()).unwrap()).collect()
    };
    for name in ["pigments/cobalt-blue.toml", "pigments/mud.toml", "papers/felt.toml", "maps/deep/edges.png"]
    {
        assert!(names.iter().any(|entry| entry == name), "{name} in {names:?}");
    }
    let mut other = Stock::builtin().pigments.get("cobalt-blue").unwrap().clone();
    other.handling.granulation = 0.123;
    let mut file = file;
    file.stock.pigments = file.stock.pigments.with(other);
    let again = read(&written(&file)).unwrap();
    assert_eq!(again.stock.pigments.get("cobalt-blue").unwrap().handling.granulation, 0.123);
}

/// The painting with its maps called otherwise.
fn with_maps(names: [&str; 2]) -> GirtinFile {
    let mut file = unpainted();
    let maps = std::mem::take(&mut file.maps.0);
    for (map, name) in file.document.map_names_mut().zip(names) {
        file.maps.0.insert(name.to_owned(), maps[&map.file].clone());
        map.file = name.to_owned();
    }
    file
}

#[test]
fn entries_of_maps_end_once_and_older_ones_are_read() {
    let entries = |bytes: &[u8]| -> Vec<String> {
        let zip = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
        let names = zip.file_names_raw().map(|name| String::from_utf8(name.to_vec()).unwrap());
        names.filter(|name| name.starts_with("maps/")).collect()
    };
    for (names, wanted) in [
        (["a.png", "deep/b.png"], ["maps/a.png", "maps/deep/b.png"]),
        (["a", "a.png"], ["maps/a.png", "maps/a.png.png"]),
        (["a.png", "a.png.png"], ["maps/a.png.png", "maps/a.png.png.png"]),
    ] {
        let file = with_maps(names);
        let bytes = written(&file);
        let again = read(&bytes).unwrap();
        assert_eq!((&again.document, &again.maps), (&file.document, &file.maps), "{names:?}");
        if names[1] != "a.png.png" {
            assert_eq!(entries(&bytes), wanted);
        }
    }
    // A map that the document does not name keeps its name as well.
    let mut file = with_maps(["a.png", "b"]);
    file.maps.0.insert("c.png".to_owned(), StoredMap::Bytes(Raster::new(1, 1, 7)));
    assert_eq!(read(&written(&file)).unwrap().maps, file.maps);
    // As files had it before.
    let file = with_maps(["a.png", "b.png"]);
    let mut new = zip::ZipArchive::new(Cursor::new(written(&file))).unwrap();
    let mut old = Vec::new();
    for at in 0..new.len() {
        let mut entry = new.by_index(at).unwrap();
        let mut bytes = Vec::new();
        std::io::Read::read_to_end(&mut entry, &mut bytes).unwrap();
        let name = entry.name().unwrap().to_string();
        let is_map = name.starts_with("maps/");
        old.push((if is_map { format!("{name}.png") } else { name }, bytes));
    }
    let old: Vec<(&str, &[u8])> = old.iter().map(|(name, bytes)| (name.as_str(), &bytes[..])).collect();
    let again = read(&zip(&old)).unwrap();
    assert_eq!((&again.document, &again.maps), (&file.document, &file.maps));
}

#[test]
fn what_could_not_be_read_again_is_not_written() {
    let fails = |change: &dyn Fn(&mut GirtinFile)| {
        let mut file = unpainted();
        change(&mut file);
        let error = file.write(Vec::new()).unwrap_err();
        assert!(error.hint().is_some() || matches!(error, GirtinFileError::Text(_)), "{error}");
        error
    };
    assert!(matches!(fails(&|file| file.maps.0.clear()), GirtinFileError::NoMap { .. }));
    assert!(matches!(fails(&|file| file.document.sheet.pixels_per_mm = 1e9), GirtinFileError::Text(_)));
    assert!(matches!(fails(&|file| file.document.sheet.relief_mm = f64::NAN), GirtinFileError::Text(_)));
    assert!(matches!(fails(&|file| file.stock = Stock::builtin()), GirtinFileError::Text(_)));
    for name in ["../x", "/x", "a//b", "", "a\\b", ".x", "a/..", &"x".repeat(300)] {
        let map = || StoredMap::Bytes(Raster::new(1, 1, 0));
        let error = fails(&|file| drop(file.maps.0.insert(name.to_owned(), map())));
        assert!(matches!(error, GirtinFileError::MapName { .. }), "{name}");
    }
}

#[test]
fn a_medium_that_fails_is_said() {
    struct Full;
    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(std::io::ErrorKind::StorageFull.into())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    assert!(matches!(unpainted().write(Full), Err(GirtinFileError::Write(_))));
}

#[test]
fn files_that_are_none_are_refused_with_their_reason() {
    let mime = MIME_TYPE.as_bytes();
    let document: &[u8] = b"{ \"format\": 1, \"sheet\": { \"size\": [3, 2] } }";
    let own = |name: &'static str, bytes: &'static [u8]| {
        zip(&[(MIMETYPE, mime), (name, bytes), (DOCUMENT, document)])
    };
    let with = |document: &'static [u8]| zip(&[(MIMETYPE, mime), (DOCUMENT, document)]);
    for (bytes, said) in [
        (b"not a zip".to_vec(), "not a whole .girtin"),
        (zip(&[]), "another archive"),
        (zip(&[("wet_mask.npy", b"")]), "state of a wash"),
        (zip(&[(DOCUMENT, document)]), "lacks `mimetype`"),
        (zip(&[(MIMETYPE, b"image/openraster"), (DOCUMENT, document)]), "archive of another type"),
        (zip(&[(MIMETYPE, mime)]), "lacks `document.json`"),
        (own("../../etc/passwd", b""), "unknown entry `../../etc/passwd`"),
        (own("maps/../x.png", b""), "unknown entry"),
        (own("maps//x.png", b""), "unknown entry"),
        (own("pigments/a/b.toml", b""), "unknown entry"),
        (own("notes.txt", b""), "unknown entry `notes.txt`"),
        (own("maps/x.png", b"no picture"), "`maps/x.png`: the picture is damaged"),
        (own("pigments/mud.toml", b"id = 3"), "pigments/mud.toml:1:"),
        (own("pigments/dirt.toml", MUD.as_bytes()), "`pigments/dirt.toml` holds `mud`"),
        (own("papers/x.toml", FELT.as_bytes()), "`papers/x.toml` holds `felt`"),
        (own("papers/felt.toml", b"\xff\xfe"), "it is not text"),
        (own("painted.json", b"{ \"format\": 9 }"), "`format` is not known"),
        (own("painted.json", b"{ \"format\": 1 }"), "lacks `thumbnail.png`"),
        (with(b"{ \"format\": 7 }"), "format 7 is not known"),
        (with(b"format = 1"), "not JSON"),
        (
            with(b"{ \"format\": 1, \"sheet\": { \"size\": [3, 2], \"printed\": [ { \"area\": { \"shape\": \"map\", \"file\": \"a\" } } ] } }"),
            "a map `a` that is not there",
        ),
    ] {
        let error = read(&bytes).unwrap_err();
        assert!(error.to_string().contains(said), "{error} for {said}");
        assert!(error.hint().is_some() || matches!(error, GirtinFileError::Text(_)), "{error}");
    }
    assert!(read(&own("maps/", b"")).is_ok(), "folders of an archive packed by hand");
}

#[test]
fn limits_are_kept() {
    let bytes = written(&painted());
    let within = |limits: &Limits| GirtinFile::read(Cursor::new(&bytes), limits);
    let all = Limits::default();
    for limits in
        [Limits { entries: 3, ..all }, Limits { bytes: 2000, ..all }, Limits { map_bytes: 500, ..all }]
    {
        let error = within(&limits).unwrap_err();
        assert!(matches!(error, GirtinFileError::TooLarge { .. }), "{error}");
    }
    let limits = Limits { maps: PictureLimits { pixels: 100, ..all.maps }, ..all };
    assert!(matches!(within(&limits), Err(GirtinFileError::Map { .. })));
    // A picture whose header promises the world.
    let mut bomb = Vec::new();
    map_bomb(&mut bomb);
    let document = b"{ \"format\": 1, \"sheet\": { \"size\": [3, 2] } }";
    let file = zip(&[(MIMETYPE, MIME_TYPE.as_bytes()), (DOCUMENT, document), ("maps/b.png", &bomb)]);
    assert!(matches!(read(&file), Err(GirtinFileError::Map { .. })));
    // A text that unpacks to more than anybody wrote.
    let vast = vec![b' '; 2 << 20];
    let file = zip(&[(MIMETYPE, MIME_TYPE.as_bytes()), (DOCUMENT, document), ("papers/x.toml", &vast)]);
    assert!(file.len() < 10_000 && matches!(read(&file), Err(GirtinFileError::TooLarge { .. })));
}

/// A grey PNG of 2^31 − 1 pixels a side, without any.
fn map_bomb(bytes: &mut Vec<u8>) {
    let mut encoder = png::Encoder::new(bytes, i32::MAX as u32, i32::MAX as u32);
    encoder.set_color(png::ColorType::Grayscale);
    drop(encoder.write_header());
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    let bytes = written(&painted());
    for end in (0..bytes.len()).step_by(97) {
        let error = read(&bytes[..end]).unwrap_err();
        assert!(matches!(error, GirtinFileError::NotGirtin { .. }), "{end}: {error}");
    }
}

proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        use std::sync::LazyLock;
        static BYTES: LazyLock<Vec<u8>> = LazyLock::new(|| written(&painted()));
        let mut bytes = BYTES.clone();
        for (at, change) in changes {
            let at = at.index(bytes.len());
            bytes[at] ^= change;
        }
        if let Ok(file) = read(&bytes) {
            prop_assert!(file.write(Vec::new()).is_ok(), "what is read can be written");
        }
    }
}

/// The first file of this format: it always opens, and paints what it did.
const FIRST: &[u8] = include_bytes!("format-1.girtin");
const FIRST_PICTURE: &[u8] = include_bytes!("format-1.png");

#[test]
fn the_first_format_always_opens_and_paints_the_same() {
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/src/girtin_file"));
    if std::env::var_os("GIRTIN_WRITE_GOLDENS").is_some() {
        // Only what it looks like may change.
        let mut bytes = Vec::new();
        write_png(&mut bytes, &picture_of(&read(FIRST).unwrap()).0, &PictureMeta::default()).unwrap();
        std::fs::write(folder.join("format-1.png"), bytes).unwrap();
        panic!("goldens were written");
    }
    let file = read(FIRST).unwrap();
    assert_eq!((file.document.title.as_str(), file.document.glazes.len()), ("Two shapes", 1));
    assert_eq!(file.document, unpainted().document);
    assert_eq!(file.maps, unpainted().maps);
    let balances = &file.painted.as_ref().unwrap().balances;
    assert!(
        balances[0].iter().all(|of_pigment| of_pigment.laid > of_pigment.total && of_pigment.lifted > 0.0)
    );
    let wanted = read_photo(Cursor::new(FIRST_PICTURE), None, &PictureLimits::default(), LinearRgb::WHITE);
    let wanted = wanted.unwrap().pixels.map(|color| LinearRgb(color.map(f64::from)));
    let picture = picture_of(&file).0;
    assert_eq!((picture.width(), picture.height()), (66, 48));
    assert!(wanted.map(|color| color.to_srgb().to_bytes()) == picture);
}
