//! A word for a region's color.

use girtin_optics::Lab;

/// Less colorful than this is grey.
const GREY_CHROMA: f64 = 8.0;

/// A word or two for a color, such as `light-blue`, fit for a file's name.
pub fn color_name(color: Lab) -> String {
    let Lab { l, a, b } = color;
    if libm::hypot(a, b) < GREY_CHROMA {
        let grey = [(18.0, "black"), (40.0, "dark-grey"), (68.0, "grey"), (90.0, "light-grey")];
        return grey.iter().find(|(end, _)| l < *end).map_or("white", |(_, word)| word).to_owned();
    }
    let hue = libm::atan2(b, a).to_degrees().rem_euclid(360.0);
    let is_earthy = (35.0..95.0).contains(&hue) && libm::hypot(a, b) < 45.0;
    let hue = if is_earthy { "brown" } else { hue_name(hue) };
    match (hue, l) {
        ("brown", 72.0..) => "beige".to_owned(),
        ("orange", ..55.0) => "brown".to_owned(),
        ("yellow", ..65.0) => "olive".to_owned(),
        ("red", 65.0..) => "pink".to_owned(),
        ("yellow" | "beige", _) => hue.to_owned(),
        (hue, ..32.0) => format!("dark-{hue}"),
        (hue, 68.0..) => format!("light-{hue}"),
        (hue, _) => hue.to_owned(),
    }
}

/// A word for an angle in the plane of a\* and b\*, degrees.
fn hue_name(hue: f64) -> &'static str {
    // sRGB's red lies at 40, orange at 63, yellow at 103, green at 136, cyan at 196, blue at 306, magenta at 328.
    const ENDS: [(f64, &str); 9] = [
        (12.0, "pink"),
        (50.0, "red"),
        (78.0, "orange"),
        (112.0, "yellow"),
        (170.0, "green"),
        (222.0, "turquoise"),
        (308.0, "blue"),
        (326.0, "violet"),
        (352.0, "purple"),
    ];
    ENDS.iter().find(|(end, _)| hue < *end).map_or("pink", |(_, word)| word)
}

#[cfg(test)]
mod tests {
    use girtin_optics::Srgb;

    use super::*;

    #[test]
    fn colors_have_the_names_that_people_give_them() {
        for (hex, name) in [
            ("#ffffff", "white"),
            ("#000000", "black"),
            ("#808080", "grey"),
            ("#ff0000", "red"),
            ("#ff8000", "orange"),
            ("#ffe000", "yellow"),
            ("#00a000", "green"),
            ("#003000", "dark-green"),
            ("#00c8c8", "light-turquoise"),
            ("#0000ff", "blue"),
            ("#87ceeb", "light-blue"),
            ("#101050", "dark-blue"),
            ("#ff00ff", "purple"),
            ("#ffb0b8", "pink"),
            ("#7a4a20", "brown"),
            ("#d8c4a0", "beige"),
            ("#707000", "olive"),
        ] {
            let color: Srgb = hex.parse().unwrap();
            assert_eq!(color_name(color.to_lab()), name, "{hex}");
        }
    }
}
