//! A sheet as the eye sees it: lit from the side.

use girtin_grid::Raster;

/// Where the light is, and how strong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RakingLight {
    /// Depth of the relief: how much higher height 1 is than height 0, mm.
    pub depth_mm: f64,
    /// Height of the lamp over the sheet, radians; low shows more relief.
    pub elevation: f64,
    /// Direction of the lamp, radians, counter-clockwise from the right; a painter's light is from the upper
    /// left.
    pub azimuth: f64,
    /// Light from all around, as a share of the whole.
    pub ambient: f64,
    /// Luminance of a level sheet, 0 to 1.
    pub white: f64,
}

impl Default for RakingLight {
    fn default() -> Self {
        Self {
            depth_mm: 0.15,
            elevation: 28.0_f64.to_radians(),
            azimuth: 135.0_f64.to_radians(),
            ambient: 0.55,
            white: 0.9,
        }
    }
}

/// How much darker a valley is than a hill, as a share of the light: less of the room reaches it.
const SHELTER: f32 = 0.08;

/// Luminance of a sheet under raking light, 0 to 1, for display.
///
/// Lambert's law on the relief, a level sheet being `white`; slopes are central differences, the border
/// continued.
pub fn raking_light(height: &Raster<f32>, cells_per_mm: f64, light: &RakingLight) -> Raster<f32> {
    let (width, rows) = (height.width(), height.height());
    // Towards the lamp, y down.
    let (flat, up) = (libm::cos(light.elevation), libm::sin(light.elevation) as f32);
    let (lx, ly) = ((flat * libm::cos(light.azimuth)) as f32, (-flat * libm::sin(light.azimuth)) as f32);
    let slope = (0.5 * light.depth_mm * cells_per_mm) as f32;
    let (ambient, white) = (light.ambient as f32, light.white as f32);
    Raster::from_fn(width, rows, |x, y| {
        let at = |x: usize, y: usize| height.at(x.min(width - 1), y.min(rows - 1));
        let dx = slope * (at(x + 1, y) - at(x.saturating_sub(1), y));
        let dy = slope * (at(x, y + 1) - at(x, y.saturating_sub(1)));
        let lambert = (up - lx * dx - ly * dy).max(0.0) / libm::sqrtf(1.0 + dx * dx + dy * dy);
        let sky = 1.0 + SHELTER * (2.0 * at(x, y) - 1.0);
        let lit = ambient * sky + (1.0 - ambient) * lambert / up.max(0.05);
        // Highlights run softly into white instead of clipping.
        let luminance = white * lit;
        let room = 1.0 - white;
        let over = (luminance - white).max(0.0);
        let luminance = if over > 0.0 { white + room * over / (over + room) } else { luminance };
        luminance.clamp(0.0, 1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_sheet_is_white() {
        let lit = raking_light(&Raster::new(3, 2, 0.5), 4.0, &RakingLight::default());
        for value in lit.as_slice() {
            assert!((value - 0.9).abs() < 1e-5, "{value}");
        }
    }

    #[test]
    fn slopes_that_face_the_upper_left_are_brighter() {
        let light = RakingLight::default();
        let falling_right = Raster::from_fn(5, 5, |x, _| 0.8 - 0.1 * x as f32);
        let falling_down = Raster::from_fn(5, 5, |_, y| 0.8 - 0.1 * y as f32);
        for hill in [falling_right, falling_down] {
            let away = raking_light(&hill, 4.0, &light).at(2, 2);
            let towards = raking_light(&hill.map(|h| 1.2 - h), 4.0, &light).at(2, 2);
            assert!(towards > 0.9 && away < 0.9, "{towards} {away}");
        }
    }

    #[test]
    fn any_relief_and_size_stays_displayable() {
        for (width, height) in [(1, 1), (1, 4), (4, 1), (0, 0), (7, 5)] {
            let field = Raster::from_fn(width, height, |x, y| ((x * 7 + y * 3) % 2) as f32);
            let light = RakingLight { depth_mm: 2.0, ..RakingLight::default() };
            let lit = raking_light(&field, 16.0, &light);
            assert!(lit.as_slice().iter().all(|value| (0.0..=1.0).contains(value)));
        }
    }
}
