//! A word for where in the picture a region lies.

/// A word or two for a place, parts of the picture's width and height from its upper left, fit for a file's name.
pub fn place_name([x, y]: [f64; 2]) -> &'static str {
    let third = |part: f64| ((part * 3.0) as usize).min(2);
    const NAMES: [[&str; 3]; 3] = [
        ["top-left", "top", "top-right"],
        ["left", "middle", "right"],
        ["bottom-left", "bottom", "bottom-right"],
    ];
    NAMES[third(y)][third(x)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_have_the_names_that_people_give_them() {
        assert_eq!(place_name([0.1, 0.1]), "top-left");
        assert_eq!(place_name([0.5, 0.9]), "bottom");
        assert_eq!(place_name([0.5, 0.5]), "middle");
        assert_eq!(place_name([1.0, 1.0]), "bottom-right");
        assert_eq!(place_name([f64::NAN, -1.0]), "top-left");
    }
}
