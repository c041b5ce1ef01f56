//! What a parameter of Girtin is.
//!
//! A parameter is one [`Row`]: id, symbol, label, unit, default, hard and soft range, doc and source. The
//! [`parameters!`] macro makes a plain struct out of rows; from the same rows come the TOML reader, the command
//! line's options, the manual and later the sliders, so none of them can drift.
//!
//! In the order data flows:
//! - [`row`]: the row, its [`Value`] and the macro that turns rows into a struct;
//! - [`read`]: TOML or JSON into such structs, with unknown keys refused and the nearest name offered;
//! - [`mod@write`]: the way back;
//! - [`manual`]: rows as a Markdown table.
#![forbid(unsafe_code)]

pub mod manual;
mod json;
pub mod read;
pub mod row;
pub mod write;

pub use read::{Place, Problem, Table, parse, parse_json};
pub use row::{Acts, Row, Value};

/// The name among `known` that `name` was most likely meant to be, if any is near enough.
///
/// Near enough is a Damerau-Levenshtein distance of at most a third of the longer name (two for short names), or
/// one name being a part of the other.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = name.to_lowercase().replace(['_', ' '], "-");
    known
        .into_iter()
        .filter_map(|candidate| {
            let plain = candidate.to_lowercase().replace(['_', ' '], "-");
            let distance = strsim::damerau_levenshtein(&wanted, &plain);
            let allowed = (wanted.chars().count().max(plain.chars().count()) / 3).max(2);
            let part =
                wanted.len().min(plain.len()) >= 4 && (plain.contains(&wanted) || wanted.contains(&plain));
            (distance <= allowed || part).then_some((!part as usize * 2 + distance, candidate))
        })
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// A hint for an unknown name: the nearest known one, or the whole list.
pub fn hint_for(name: &str, known: &[&str]) -> String {
    match nearest(name, known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if known.is_empty() => "nothing is known here".to_owned(),
        None => format!("known here: {}", known.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_name_ignores_case_and_dashes() {
        let known = ["viscosity", "viscous_drag", "edge_darkening"];
        assert_eq!(nearest("viscosty", known), Some("viscosity"));
        assert_eq!(nearest("Viscous-Drag", known), Some("viscous_drag"));
        assert_eq!(nearest("edge", known), Some("edge_darkening"));
        assert_eq!(nearest("zzzzzz", known), None);
        assert_eq!(nearest("bogus", ["u", "v"]), None);
    }

    #[test]
    fn a_hint_lists_everything_when_nothing_is_near() {
        assert_eq!(hint_for("q", &["alpha", "beta"]), "known here: alpha, beta");
    }
}
