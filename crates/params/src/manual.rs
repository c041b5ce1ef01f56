//! Rows as a Markdown table.

use std::fmt::Write as _;

use crate::row::Row;

/// A Markdown table of rows, for the generated manual.
pub fn markdown(rows: &[Row]) -> String {
    let mut page = String::from(
        "| parameter | symbol | unit | default | allowed | usual | what it does | source |\n|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let (low, high) = row.hard;
        let (from, to) = row.soft;
        // Writing to a String cannot fail.
        let _ = writeln!(
            page,
            "| `{}` | {} | {} | {} | {low} to {high} | {from} to {to} | **{}.** {} | {} |",
            row.id, row.symbol, row.unit, row.default, row.label, row.doc, row.source
        );
    }
    page
}
