//! Where something is done: shapes on the sheet in millimetres, and how much of each cell they cover.

use std::ops::Range;

use girtin_grid::noise::{Fractal, Noise};
use girtin_grid::{Raster, random};
use girtin_params::Table;
use girtin_params::read::Fault;

use crate::document::MapName;

/// Farthest coordinate, mm.
const MAX_MM: f64 = 10_000.0;

/// Length over which a brush's water rises from the edge of its mark, mm.
pub const TAPER_MM: f64 = 0.5;

/// A shape with its edge.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    /// The shape.
    pub shape: Shape,
    /// Width over which the edge fades, mm.
    pub soft_mm: f64,
    /// How far the edge strays from the shape, mm.
    pub ragged_mm: f64,
    /// Length of a stray of the edge, mm.
    pub ragged_scale_mm: f64,
    /// Only where the paper is higher, at the beginning and at the end of a stroke: drybrush.
    pub above_height: [f64; 2],
    /// How far that height differs from bristle to bristle of a stroke.
    pub bristles: f64,
}

impl Default for Area {
    fn default() -> Self {
        Self {
            shape: Shape::Everywhere,
            soft_mm: 0.0,
            ragged_mm: 0.0,
            ragged_scale_mm: 4.0,
            above_height: [0.0; 2],
            bristles: 0.0,
        }
    }
}

/// A shape on the sheet; coordinates in mm from its upper left corner.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// The whole sheet.
    Everywhere,
    /// A disc.
    Disc {
        /// Center.
        center: [f64; 2],
        /// Radius.
        radius: f64,
    },
    /// A rectangle.
    Rectangle {
        /// Left upper corner.
        from: [f64; 2],
        /// Right lower corner.
        to: [f64; 2],
    },
    /// A polygon, its inside by the even-odd rule.
    Polygon {
        /// Corners.
        points: Vec<[f64; 2]>,
    },
    /// A stroke of a round brush.
    Stroke {
        /// Points of the path.
        points: Vec<[f64; 2]>,
        /// Width at the beginning and at the end.
        width: [f64; 2],
    },
    /// A picture or array stretched over the sheet: 0 is nothing, 1 everything.
    Map(MapName),
}

impl Area {
    pub(crate) fn read(table: &Table<'_>) -> Result<Self, Fault> {
        let coordinate = -MAX_MM..=MAX_MM;
        let length = 0.0..=MAX_MM;
        let point = |key: &str| {
            table.reals::<2>(key, coordinate.clone())?.ok_or_else(|| {
                table
                    .fault(key, format!("the area lacks `{key}`"))
                    .hint(format!("add `{key} = [x, y]` in mm"))
            })
        };
        let points = |least: usize| {
            let points = table.points("points", coordinate.clone())?.unwrap_or_default();
            if points.len() < least {
                let message = format!("`points` has {} points, at least {least} are needed", points.len());
                return Err(table.fault("points", message).hint("give a list of [x, y] in mm"));
            }
            Ok(points)
        };
        #[derive(Clone, Copy)]
        enum Kind {
            Everywhere,
            Disc,
            Rectangle,
            Polygon,
            Stroke,
            Map,
        }
        let kinds = [
            ("everywhere", Kind::Everywhere),
            ("disc", Kind::Disc),
            ("rectangle", Kind::Rectangle),
            ("polygon", Kind::Polygon),
            ("stroke", Kind::Stroke),
            ("map", Kind::Map),
        ];
        let shape = match table.word("shape", &kinds)?.unwrap_or(Kind::Everywhere) {
            Kind::Everywhere => Shape::Everywhere,
            Kind::Disc => {
                Shape::Disc { center: point("center")?, radius: table.need_real("radius", length.clone())? }
            }
            Kind::Rectangle => Shape::Rectangle { from: point("from")?, to: point("to")? },
            Kind::Polygon => Shape::Polygon { points: points(3)? },
            Kind::Stroke => {
                let begin = table.need_real("width", length.clone())?;
                let end = table.real("end_width", length.clone())?.unwrap_or(begin);
                Shape::Stroke { points: points(1)?, width: [begin, end] }
            }
            Kind::Map => Shape::Map(MapName { file: table.need_text("file")?, place: table.place("file") }),
        };
        Ok(Self {
            shape,
            soft_mm: table.real("soft", length.clone())?.unwrap_or(0.0),
            ragged_mm: table.real("ragged", length)?.unwrap_or(0.0),
            ragged_scale_mm: table.real("ragged_scale", 0.01..=MAX_MM)?.unwrap_or(4.0),
            above_height: table.reals("above_height", 0.0..=1.0)?.unwrap_or([0.0; 2]),
            bristles: table.real("bristles", 0.0..=1.0)?.unwrap_or(0.0),
        })
    }
}

/// The cells of a sheet: how large they are, their paper, and the seed of its accidents.
#[derive(Clone, Copy, Debug)]
pub struct Canvas<'a> {
    /// Height of the paper in each cell.
    pub height: &'a Raster<f32>,
    /// Cells a millimetre.
    pub cells_per_mm: f64,
    /// Seed of ragged edges.
    pub seed: u64,
    /// Where the first cell's corner is on the sheet, cells.
    pub origin: [f64; 2],
    /// Columns and rows of the whole sheet, cells.
    pub sheet: [f64; 2],
}

impl<'a> Canvas<'a> {
    /// A whole sheet.
    pub fn whole(height: &'a Raster<f32>, cells_per_mm: f64, seed: u64) -> Self {
        let sheet = [height.width() as f64, height.height() as f64];
        Self { height, cells_per_mm, seed, origin: [0.0; 2], sheet }
    }
}

/// How much of each cell an area covers, over the rectangle of cells that it may touch.
#[derive(Clone, Debug)]
pub struct Coverage {
    /// First column.
    pub x: usize,
    /// First row.
    pub y: usize,
    /// 0 to 1.
    pub amount: Raster<f32>,
}

impl Area {
    fn is_dry(&self) -> bool {
        self.bristles > 0.0 || self.above_height != [0.0; 2]
    }

    /// Columns and rows of the cells that it may touch, on a canvas of `size` columns and rows.
    pub(crate) fn extent(&self, size: [usize; 2], cells_per_mm: f64, origin: [f64; 2]) -> [Range<usize>; 2] {
        let reach = self.soft_mm + self.ragged_mm;
        let [low, high] = self.shape.bounds().map_or([[0.0; 2], [f64::INFINITY; 2]], |[low, high]| {
            [low.map(|x| x - reach), high.map(|x| x + reach)]
        });
        let cell = |mm: f64, axis: usize| (mm * cells_per_mm - origin[axis]).clamp(0.0, size[axis] as f64);
        [0, 1].map(|axis| cell(low[axis], axis).floor() as usize..cell(high[axis], axis).ceil() as usize)
    }

    /// Lays the area on a canvas; `map` is the raster of [`Shape::Map`].
    ///
    /// Two areas on one canvas stray alike, so that the water and the pigment of one stroke have the same edge.
    pub fn cover(&self, canvas: &Canvas<'_>, map: Option<&Raster<f32>>) -> Coverage {
        self.cover_by(canvas, map, |distance| {
            if self.soft_mm > 0.0 {
                0.5 - distance / self.soft_mm
            } else {
                f64::from(u8::from(distance < 0.0))
            }
        })
    }

    /// The same, rising from the edge inward over a length: a brush holds less water at its rim than in its belly.
    pub fn cover_tapered(&self, canvas: &Canvas<'_>, map: Option<&Raster<f32>>, taper_mm: f64) -> Coverage {
        self.cover_by(canvas, map, |distance| -distance / taper_mm)
    }

    /// Lays the area on a canvas; `covered` tells from the distance inside its edge, negative, how far a place is covered.
    fn cover_by(
        &self,
        canvas: &Canvas<'_>,
        map: Option<&Raster<f32>>,
        covered: impl Fn(f64) -> f64 + Sync,
    ) -> Coverage {
        let (width, height) = (canvas.height.width(), canvas.height.height());
        let reach = self.soft_mm + self.ragged_mm;
        let [columns, rows] = self.extent([width, height], canvas.cells_per_mm, canvas.origin);
        let (x0, x1, y0, y1) = (columns.start, columns.end, rows.start, rows.end);
        if let (Shape::Map(_), Some(map), false) = (&self.shape, map, self.is_dry())
            && canvas.origin == [0.0; 2]
            && canvas.sheet == [width as f64, height as f64]
            && (map.width(), map.height()) == (width, height)
        {
            // A value for each cell is that cell's.
            return Coverage { x: 0, y: 0, amount: map.map(|amount| amount.clamp(0.0, 1.0)) };
        }
        let noise = Noise::new(canvas.seed, random::stage("ragged edge"));
        let bristles = Noise::new(canvas.seed, random::stage("bristles"));
        let amount = Raster::by_rows(x1 - x0, y1 - y0, |x, y| {
            let (x, y) = (x0 + x, y0 + y);
            let cell = [canvas.origin[0] + x as f64 + 0.5, canvas.origin[1] + y as f64 + 0.5];
            let at = cell.map(|cells| cells / canvas.cells_per_mm);
            if self.is_dry() {
                let [along, across] = self.shape.along_and_across(at);
                let [begin, end] = self.above_height;
                let mut least = begin + along * (end - begin);
                if self.bristles > 0.0 {
                    // A bristle is a quarter millimetre wide and loses its color within a twentieth of the stroke.
                    least += self.bristles
                        * bristles.fbm([along * 20.0, across * 4.0], Fractal { octaves: 2, gain: 0.7 });
                }
                if f64::from(canvas.height.at(x, y)) < least {
                    return 0.0;
                }
            }
            if let (Shape::Map(_), Some(map)) = (&self.shape, map) {
                let of_map = [map.width() as f64, map.height() as f64];
                let [x, y] = [0, 1].map(|axis| (cell[axis] / canvas.sheet[axis] * of_map[axis]) as f32);
                return map.sample(x, y).clamp(0.0, 1.0);
            }
            let mut distance = self.shape.distance(at);
            // The noise is dear; far from the edge it changes nothing.
            if self.ragged_mm > 0.0 && distance.abs() < reach + TAPER_MM {
                let scaled = at.map(|mm| mm / self.ragged_scale_mm);
                distance += self.ragged_mm * noise.fbm(scaled, Fractal { octaves: 5, gain: 0.55 });
            }
            let covered = covered(distance).clamp(0.0, 1.0);
            (covered * covered * (3.0 - 2.0 * covered)) as f32
        });
        Coverage { x: x0, y: y0, amount }
    }
}

impl Shape {
    /// The corners of the rectangle around the shape, unless it has no end.
    fn bounds(&self) -> Option<[[f64; 2]; 2]> {
        let around = |points: &[[f64; 2]], by: f64| {
            let fold = |pick: fn(f64, f64) -> f64, start: f64| {
                [0, 1].map(|axis| points.iter().map(|point| point[axis]).fold(start, pick))
            };
            [fold(f64::min, f64::INFINITY).map(|x| x - by), fold(f64::max, f64::NEG_INFINITY).map(|x| x + by)]
        };
        match self {
            Self::Everywhere | Self::Map(_) => None,
            Self::Disc { center, radius } => Some(around(&[*center], *radius)),
            Self::Rectangle { from, to } => Some(around(&[*from, *to], 0.0)),
            Self::Polygon { points } => Some(around(points, 0.0)),
            Self::Stroke { points, width } => Some(around(points, width[0].max(width[1]) / 2.0)),
        }
    }

    /// Where a point lies in a stroke: part of its length, 0 to 1, and mm to the side; for other shapes 0 and the row.
    fn along_and_across(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let Self::Stroke { points, .. } = self else { return [0.0, y] };
        let length = |p: &[[f64; 2]]| libm::hypot(p[1][0] - p[0][0], p[1][1] - p[0][1]);
        let whole: f64 = points.windows(2).map(length).sum();
        let (mut before, mut nearest, mut place) = (0.0, f64::INFINITY, [0.0, 0.0]);
        for segment in points.windows(2) {
            let (distance, part) = to_segment([x, y], segment[0], segment[1]);
            if distance < nearest {
                nearest = distance;
                let [[x0, y0], [x1, y1]] = [segment[0], segment[1]];
                let side = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0);
                let along = (before + part * length(segment)) / whole.max(f64::MIN_POSITIVE);
                place = [along, distance.copysign(side)];
            }
            before += length(segment);
        }
        place
    }

    /// Distance from the shape's edge, mm, negative inside.
    fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        match self {
            Self::Everywhere | Self::Map(_) => f64::NEG_INFINITY,
            Self::Disc { center, radius } => libm::hypot(x - center[0], y - center[1]) - radius,
            Self::Rectangle { from, to } => {
                let beyond = [0, 1].map(|axis| {
                    let at = [x, y][axis];
                    let (low, high) = (from[axis].min(to[axis]), from[axis].max(to[axis]));
                    (low - at).max(at - high)
                });
                let outside = libm::hypot(beyond[0].max(0.0), beyond[1].max(0.0));
                outside + beyond[0].max(beyond[1]).min(0.0)
            }
            Self::Polygon { points } => {
                let mut nearest = f64::INFINITY;
                let mut inside = false;
                for (i, &from) in points.iter().enumerate() {
                    let to = points[(i + 1) % points.len()];
                    nearest = nearest.min(to_segment([x, y], from, to).0);
                    if (from[1] > y) != (to[1] > y) {
                        let crossing = from[0] + (y - from[1]) / (to[1] - from[1]) * (to[0] - from[0]);
                        inside ^= x < crossing;
                    }
                }
                if inside { -nearest } else { nearest }
            }
            Self::Stroke { points, width } => {
                let lengths: Vec<f64> =
                    points.windows(2).map(|p| libm::hypot(p[1][0] - p[0][0], p[1][1] - p[0][1])).collect();
                let whole: f64 = lengths.iter().sum();
                let half = |along: f64| {
                    let part = if whole > 0.0 { along / whole } else { 0.0 };
                    (width[0] + part * (width[1] - width[0])) / 2.0
                };
                if points.len() == 1 {
                    return libm::hypot(x - points[0][0], y - points[0][1]) - half(0.0);
                }
                let mut before = 0.0;
                let mut nearest = f64::INFINITY;
                for (segment, length) in points.windows(2).zip(&lengths) {
                    let (distance, part) = to_segment([x, y], segment[0], segment[1]);
                    nearest = nearest.min(distance - half(before + part * length));
                    before += length;
                }
                nearest
            }
        }
    }
}

/// Distance from a segment, and where along it the nearest point is, 0 to 1.
fn to_segment([x, y]: [f64; 2], from: [f64; 2], to: [f64; 2]) -> (f64, f64) {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length2 = dx * dx + dy * dy;
    let along = if length2 > 0.0 { ((x - from[0]) * dx + (y - from[1]) * dy) / length2 } else { 0.0 };
    let along = along.clamp(0.0, 1.0);
    (libm::hypot(x - from[0] - along * dx, y - from[1] - along * dy), along)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn covered(area: &Area) -> f64 {
        let height = Raster::from_fn(100, 80, |x, _| if x < 50 { 0.3 } else { 0.7 });
        let canvas = Canvas::whole(&height, 4.0, 1);
        let coverage = area.cover(&canvas, None);
        coverage.amount.as_slice().iter().map(|&amount| f64::from(amount)).sum::<f64>() / 16.0
    }

    fn area(shape: Shape) -> Area {
        Area { shape, ..Area::default() }
    }

    #[test]
    fn shapes_cover_their_area() {
        let square = vec![[5.0, 5.0], [15.0, 5.0], [15.0, 15.0], [5.0, 15.0]];
        for (shape, wanted) in [
            (Shape::Everywhere, 500.0),
            (Shape::Disc { center: [12.0, 10.0], radius: 6.0 }, core::f64::consts::PI * 36.0),
            (Shape::Rectangle { from: [5.0, 15.0], to: [15.0, 5.0] }, 100.0),
            (Shape::Polygon { points: square }, 100.0),
            (
                Shape::Stroke { points: vec![[5.0, 10.0], [15.0, 10.0]], width: [4.0, 4.0] },
                40.0 + core::f64::consts::PI * 4.0,
            ),
        ] {
            let found = covered(&area(shape.clone()));
            assert!((found / wanted - 1.0).abs() < 0.02, "{shape:?}: {found} for {wanted}");
            let soft = covered(&Area { soft_mm: 1.0, ..area(shape.clone()) });
            assert!((soft / wanted - 1.0).abs() < 0.05, "soft {shape:?}: {soft} for {wanted}");
            let ragged = covered(&Area { ragged_mm: 0.5, ..area(shape.clone()) });
            assert!((ragged / wanted - 1.0).abs() < 0.1, "ragged {shape:?}: {ragged} for {wanted}");
        }
    }

    #[test]
    fn drybrush_touches_only_high_paper() {
        assert_eq!(covered(&Area { above_height: [0.5; 2], ..Area::default() }), 250.0);
    }

    #[test]
    fn shapes_off_the_sheet_cover_nothing() {
        assert_eq!(covered(&area(Shape::Disc { center: [-50.0, 900.0], radius: 6.0 })), 0.0);
    }
}
