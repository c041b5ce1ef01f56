//! Documents.
#![no_main]

use std::sync::LazyLock;

use girtin::painting::{Document, Stock};
use libfuzzer_sys::fuzz_target;

static STOCK: LazyLock<Stock> = LazyLock::new(Stock::builtin);

fuzz_target!(|text: &str| {
    if let Ok(document) = Document::from_toml("fuzz", text, &STOCK) {
        let _ = (document.steps(), document.picture_size(), document.cells());
    }
});
