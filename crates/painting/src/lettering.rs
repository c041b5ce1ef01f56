//! Small plain letters, a bit a pixel: enough for a name below a picture.

use girtin_grid::Raster;

/// Rows of a letter.
pub const HEIGHT: usize = 7;
/// Columns of a letter, and from one to the next.
const WIDTH: usize = 5;
const STEP: usize = 6;

/// Rows of each letter from the top, the highest bit at the left.
#[rustfmt::skip]
const LETTERS: [(char, [u8; HEIGHT]); 38] = [
    ('a', [0b00000, 0b00000, 0b01110, 0b00001, 0b01111, 0b10001, 0b01111]),
    ('b', [0b10000, 0b10000, 0b11110, 0b10001, 0b10001, 0b10001, 0b11110]),
    ('c', [0b00000, 0b00000, 0b01110, 0b10001, 0b10000, 0b10001, 0b01110]),
    ('d', [0b00001, 0b00001, 0b01111, 0b10001, 0b10001, 0b10001, 0b01111]),
    ('e', [0b00000, 0b00000, 0b01110, 0b10001, 0b11111, 0b10000, 0b01110]),
    ('f', [0b00110, 0b01000, 0b11110, 0b01000, 0b01000, 0b01000, 0b01000]),
    ('g', [0b00000, 0b00000, 0b01111, 0b10001, 0b01111, 0b00001, 0b01110]),
    ('h', [0b10000, 0b10000, 0b11110, 0b10001, 0b10001, 0b10001, 0b10001]),
    ('i', [0b00100, 0b00000, 0b01100, 0b00100, 0b00100, 0b00100, 0b01110]),
    ('j', [0b00010, 0b00000, 0b00110, 0b00010, 0b00010, 0b10010, 0b01100]),
    ('k', [0b10000, 0b10000, 0b10010, 0b10100, 0b11000, 0b10100, 0b10010]),
    ('l', [0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110]),
    ('m', [0b00000, 0b00000, 0b11010, 0b10101, 0b10101, 0b10101, 0b10101]),
    ('n', [0b00000, 0b00000, 0b11110, 0b10001, 0b10001, 0b10001, 0b10001]),
    ('o', [0b00000, 0b00000, 0b01110, 0b10001, 0b10001, 0b10001, 0b01110]),
    ('p', [0b00000, 0b00000, 0b11110, 0b10001, 0b11110, 0b10000, 0b10000]),
    ('q', [0b00000, 0b00000, 0b01111, 0b10001, 0b01111, 0b00001, 0b00001]),
    ('r', [0b00000, 0b00000, 0b10110, 0b11000, 0b10000, 0b10000, 0b10000]),
    ('s', [0b00000, 0b00000, 0b01111, 0b10000, 0b01110, 0b00001, 0b11110]),
    ('t', [0b01000, 0b01000, 0b11110, 0b01000, 0b01000, 0b01001, 0b00110]),
    ('u', [0b00000, 0b00000, 0b10001, 0b10001, 0b10001, 0b10001, 0b01111]),
    ('v', [0b00000, 0b00000, 0b10001, 0b10001, 0b10001, 0b01010, 0b00100]),
    ('w', [0b00000, 0b00000, 0b10001, 0b10101, 0b10101, 0b10101, 0b01010]),
    ('x', [0b00000, 0b00000, 0b10001, 0b01010, 0b00100, 0b01010, 0b10001]),
    ('y', [0b00000, 0b00000, 0b10001, 0b10001, 0b01111, 0b00001, 0b01110]),
    ('z', [0b00000, 0b00000, 0b11111, 0b00010, 0b00100, 0b01000, 0b11111]),
    ('0', [0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110]),
    ('1', [0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110]),
    ('2', [0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111]),
    ('3', [0b01110, 0b10001, 0b00001, 0b00110, 0b00001, 0b10001, 0b01110]),
    ('4', [0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010]),
    ('5', [0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110]),
    ('6', [0b01110, 0b10000, 0b11110, 0b10001, 0b10001, 0b10001, 0b01110]),
    ('7', [0b11111, 0b00001, 0b00010, 0b00100, 0b00100, 0b00100, 0b00100]),
    ('8', [0b01110, 0b10001, 0b01110, 0b10001, 0b10001, 0b10001, 0b01110]),
    ('9', [0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00001, 0b01110]),
    ('-', [0b00000, 0b00000, 0b00000, 0b01110, 0b00000, 0b00000, 0b00000]),
    ('.', [0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b00100]),
];

/// Writes a line, `scale` pixels to a bit, from `[left, top]`; what does not fit is left out, and unknown letters are
/// blanks.
pub fn write(
    picture: &mut Raster<[u8; 3]>,
    [left, top]: [usize; 2],
    scale: usize,
    color: [u8; 3],
    line: &str,
) {
    for (at, letter) in line.chars().enumerate() {
        let known = LETTERS.iter().find(|(known, _)| *known == letter.to_ascii_lowercase());
        let Some((_, rows)) = known else { continue };
        for y in 0..HEIGHT * scale {
            for x in 0..WIDTH * scale {
                let is_ink = rows[y / scale] >> (WIDTH - 1 - x / scale) & 1 == 1;
                let (x, y) = (left + at * STEP * scale + x, top + y);
                if is_ink && x < picture.width() && y < picture.height() {
                    picture.row_mut(y)[x] = color;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_are_ink_and_differ() {
        let mut seen: Vec<Raster<[u8; 3]>> = Vec::new();
        for (letter, _) in LETTERS {
            let mut picture = Raster::new(2 * STEP, HEIGHT, [255; 3]);
            write(&mut picture, [0, 0], 1, [0; 3], &letter.to_string());
            assert!(picture.as_slice().contains(&[0; 3]), "{letter}");
            assert!(!seen.contains(&picture), "{letter}");
            seen.push(picture);
        }
    }

    #[test]
    fn what_does_not_fit_is_left_out() {
        let mut picture = Raster::new(9, 11, [255; 3]);
        write(&mut picture, [3, 1], 2, [0; 3], "wet-in-wet, ä");
        assert!(picture.as_slice().contains(&[0; 3]));
    }
}
