//! What is drawn before it is painted, the washes that fill it, and marks of a brush.

use girtin_params::Table;
use girtin_params::read::Fault;
use girtin_params::write::{Node, Tree};

/// Most figures of a drawing: a label each, in two bytes.
pub const MAX_FIGURES: usize = 60_000;

/// Most points of a mark's path: every place near it looks at all of them.
pub const MAX_POINTS: usize = 400;

/// Farthest from the sheet's corner that anything is drawn, mm.
const MAX_MM: f64 = 1e5;

/// A closed contour, drawn once for all washes that fill it. Every place of the sheet belongs to the figure that was drawn
/// last over it, so two that meet share one contour, and one that no wash fills stays bare, as under masking fluid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figure {
    /// The outline and those of its holes, mm: inside is what an odd number of them go around.
    pub rings: Vec<Vec<[f64; 2]>>,
}

/// A wash over figures of the drawing: they are one wet shape, in which each has a mix of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Fill {
    /// The figures.
    pub figures: Vec<FilledFigure>,
    /// How deep a film.
    pub water: f64,
    /// How much film and paint vary from place to place, 0 to 1.
    pub uneven: f64,
    /// How far pigments part from each other, 0 to 1, so that hues shift within a shape, as when a brush is charged anew.
    pub charged: f64,
    /// Over how many millimetres they do.
    pub uneven_scale_mm: f64,
    /// How strongly paint gathers along crisp contours, 0 to 2; it does so here more and there less.
    pub rim: f64,
    /// Stretches of contours that are not crisp.
    pub edges: Vec<EdgeStretch>,
}

/// What a figure is filled with.
#[derive(Clone, Debug, PartialEq)]
pub struct FilledFigure {
    /// Which of the drawing, from 0.
    pub figure: usize,
    /// How much of each of the glaze's pigments; where there is an end, at its beginning.
    pub amounts: Vec<f64>,
    /// A mix that changes steadily along a line.
    pub graded: Option<Graded>,
    /// Figures of one family run into each other; where two families meet, each ends crisply.
    pub family: u32,
    /// Direction that it is laid in, degrees clockwise from the rows: the hairs of a brush leave traces along it. `None`: the
    /// one that washes are laid in.
    pub laid_degrees: Option<f64>,
    /// How crisp its contour stays within its family, 0 to 1: 0 runs as far as the water carries it.
    pub held: f64,
}

/// A steady change of a mix.
#[derive(Clone, Debug, PartialEq)]
pub struct Graded {
    /// From where to where, mm.
    pub line: [[f64; 2]; 2],
    /// How much of each pigment at the line's end.
    pub amounts: Vec<f64>,
}

/// A stretch of a contour that is not crisp.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeStretch {
    /// Where it is, mm; contours close to this line are of it.
    pub path: Vec<[f64; 2]>,
    /// How far the paint fades into wet paper, mm.
    pub lost_mm: f64,
    /// How far a brush that ran dry breaks up on the paper's tooth, mm.
    pub dry_mm: f64,
}

/// One gesture of a brush, laid on dry paper.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Points that the brush goes through, mm, on a smooth curve.
    pub path: Vec<[f64; 2]>,
    /// Width of the mark at each point, mm; between them it changes steadily.
    pub widths: Vec<f64>,
    /// How much more of the width lies to the left of the path than to the right, −0.5 to 0.5.
    pub side: f64,
    /// For a flat brush the angle that its ends are cut at, degrees from square; without it ends are round.
    pub chisel_degrees: Option<f64>,
    /// How dry the brush is at the beginning and at the end, 0 wet to 1 dry, and at which part of the length it begins to run
    /// out.
    pub dry: [f64; 3],
    /// Width and length of the streaks that bristles leave, mm, and how strong they are.
    pub bristles: [f64; 3],
    /// How dry the left side is, as when a brush is dragged on its belly, and over how many millimetres.
    pub drag: [f64; 2],
    /// How much of each of the glaze's pigments.
    pub amounts: Vec<f64>,
    /// How much of each at the end, where the brush was charged with a second color.
    pub end_amounts: Option<Vec<f64>>,
    /// How much pigment gathers where the brush is lifted.
    pub bead: f64,
    /// For a knife instead of a brush: how much of what is dry it scrapes off where it touches, 0 to 1, down to the paper.
    pub scraped: f64,
}

impl Default for Mark {
    fn default() -> Self {
        Self {
            path: Vec::new(),
            widths: Vec::new(),
            side: 0.0,
            chisel_degrees: None,
            dry: [0.0, 0.0, 0.6],
            bristles: [0.45, 14.0, 0.0],
            drag: [0.0, 1.0],
            amounts: Vec::new(),
            end_amounts: None,
            bead: 0.4,
            scraped: 0.0,
        }
    }
}

fn need_points(table: &Table<'_>, key: &str, least: usize) -> Result<Vec<[f64; 2]>, Fault> {
    let points = table.points(key, -MAX_MM..=MAX_MM)?.unwrap_or_default();
    if points.len() < least {
        let message = format!("`{key}` has {} points, at least {least} are needed", points.len());
        return Err(table.fault(key, message).hint("give a list of [x, y] in mm"));
    }
    Ok(points)
}

/// Amounts of each of so many pigments.
pub(super) fn read_amounts(table: &Table<'_>, key: &str, pigments: usize) -> Result<Vec<f64>, Fault> {
    let amounts = table.real_list(key, 0.0..=100.0)?.unwrap_or_default();
    if amounts.len() == pigments {
        return Ok(amounts);
    }
    let message = format!("`{key}` has {} numbers for {pigments} pigments", amounts.len());
    Err(table.fault(key, message).hint("give one amount for each of the glaze's pigments"))
}

fn points_node(points: &[[f64; 2]]) -> Node {
    Node::List(points.iter().map(|&point| point.into()).collect())
}

impl Figure {
    pub(super) fn read(table: &Table<'_>) -> Result<Self, Fault> {
        let mut rings = vec![need_points(table, "outline", 3)?];
        let holes = table.tables("holes", |hole| need_points(hole, "outline", 3))?;
        rings.extend(holes.unwrap_or_default());
        Ok(Self { rings })
    }

    pub(super) fn tree(&self) -> Tree {
        let (outline, holes) = self.rings.split_first().map_or((&[][..], &[][..]), |(a, b)| (&a[..], b));
        let hole = |ring: &Vec<[f64; 2]>| Tree::new().with("outline", points_node(ring));
        let holes = (!holes.is_empty())
            .then(|| Node::List(holes.iter().map(|ring| Node::Inline(hole(ring))).collect()));
        Tree::new().with("outline", points_node(outline)).with_some("holes", holes)
    }
}

impl Fill {
    pub(super) fn read(table: &Table<'_>, pigments: usize, drawn: usize) -> Result<Self, Fault> {
        let figures = table.tables("figures", |filled| {
            let last = u32::try_from(drawn.saturating_sub(1)).unwrap_or(u32::MAX);
            let figure = filled.count("figure", 0..=u32::MAX)?.unwrap_or(0);
            if figure as usize >= drawn {
                let hint = if drawn == 0 {
                    "give the document a `[[drawing]]` first".to_owned()
                } else {
                    format!("figures are counted from 0; the last is {last}")
                };
                let message = format!("figure {figure} is not of the drawing, which has {drawn}");
                return Err(filled.fault("figure", message).hint(hint));
            }
            let graded = filled.table("graded", |graded| {
                let line = need_points(graded, "line", 2)?;
                Ok(Graded { line: [line[0], line[1]], amounts: read_amounts(graded, "amounts", pigments)? })
            })?;
            Ok(FilledFigure {
                figure: figure as usize,
                amounts: read_amounts(filled, "amounts", pigments)?,
                graded,
                family: filled.count("family", 0..=u32::MAX)?.unwrap_or(0),
                laid_degrees: filled.real("laid", -360.0..=360.0)?,
                held: filled.real("held", 0.0..=1.0)?.unwrap_or(1.0),
            })
        })?;
        let edges = table.tables("edges", |edge| {
            let length = 0.0..=1000.0;
            Ok(EdgeStretch {
                path: need_points(edge, "path", 1)?,
                lost_mm: edge.real("lost", length.clone())?.unwrap_or(0.0),
                dry_mm: edge.real("dry", length)?.unwrap_or(0.0),
            })
        })?;
        Ok(Self {
            figures: figures.unwrap_or_default(),
            water: table.real("water", 0.0..=100.0)?.unwrap_or(0.45),
            uneven: table.real("uneven", 0.0..=1.0)?.unwrap_or(0.0),
            charged: table.real("charged", 0.0..=1.0)?.unwrap_or(0.0),
            uneven_scale_mm: table.real("uneven_scale", 0.1..=1000.0)?.unwrap_or(12.0),
            rim: table.real("rim", 0.0..=2.0)?.unwrap_or(1.0),
            edges: edges.unwrap_or_default(),
        })
    }

    pub(super) fn tree(&self, tree: Tree) -> Tree {
        let filled = |filled: &FilledFigure| {
            let graded = filled.graded.as_ref().map(|graded| {
                let line = points_node(&graded.line);
                Node::Inline(Tree::new().with("line", line).with("amounts", graded.amounts.clone()))
            });
            let tree =
                Tree::new().with("figure", filled.figure as u64).with("amounts", filled.amounts.clone());
            let tree = tree.with_some("graded", graded);
            let tree = tree.with_some("laid", filled.laid_degrees);
            let tree = tree.with_some("held", (filled.held != 1.0).then_some(filled.held));
            Node::Inline(tree.with_some("family", (filled.family != 0).then_some(filled.family)))
        };
        let edge = |edge: &EdgeStretch| {
            let tree = Tree::new().with("path", points_node(&edge.path));
            Node::Inline(tree.with("lost", edge.lost_mm).with("dry", edge.dry_mm))
        };
        tree.with("water", self.water)
            .with("uneven", self.uneven)
            .with("charged", self.charged)
            .with("uneven_scale", self.uneven_scale_mm)
            .with("rim", self.rim)
            .with("figures", Node::List(self.figures.iter().map(filled).collect()))
            .with("edges", Node::List(self.edges.iter().map(edge).collect()))
    }
}

impl Mark {
    pub(super) fn read(table: &Table<'_>, pigments: usize) -> Result<Self, Fault> {
        let default = Self::default();
        let path = need_points(table, "path", 1)?;
        if path.len() > MAX_POINTS {
            let message = format!("`path` has {} points; a mark has {MAX_POINTS} at most", path.len());
            return Err(table.fault("path", message).hint("make several marks of it"));
        }
        let mut widths = table.real_list("widths", 0.0..=1000.0)?.unwrap_or_default();
        if widths.len() == 1 {
            widths = vec![widths[0]; path.len()];
        }
        if widths.len() != path.len() {
            let message = format!("`widths` has {} numbers for {} points", widths.len(), path.len());
            return Err(table
                .fault("widths", message)
                .hint("give one for each point of `path`, or one for all"));
        }
        let end_amounts =
            if table.has("end_amounts") { Some(read_amounts(table, "end_amounts", pigments)?) } else { None };
        Ok(Self {
            path,
            widths,
            side: table.real("side", -0.5..=0.5)?.unwrap_or(default.side),
            chisel_degrees: table.real("chisel", -80.0..=80.0)?,
            dry: table.reals("dry", 0.0..=2.0)?.unwrap_or(default.dry),
            bristles: table.reals("bristles", 0.0..=1000.0)?.unwrap_or(default.bristles),
            drag: table.reals("drag", 0.0..=1000.0)?.unwrap_or(default.drag),
            amounts: read_amounts(table, "amounts", pigments)?,
            end_amounts,
            bead: table.real("bead", 0.0..=10.0)?.unwrap_or(default.bead),
            scraped: table.real("scraped", 0.0..=1.0)?.unwrap_or(default.scraped),
        })
    }

    pub(super) fn node(&self) -> Node {
        let default = Self::default();
        let unless = |same: bool, node: Node| (!same).then_some(node);
        let tree = Tree::new()
            .with("path", points_node(&self.path))
            .with("widths", self.widths.clone())
            .with_some("side", unless(self.side == default.side, self.side.into()))
            .with_some("chisel", self.chisel_degrees)
            .with_some("dry", unless(self.dry == default.dry, self.dry.into()))
            .with_some("bristles", unless(self.bristles == default.bristles, self.bristles.into()))
            .with_some("drag", unless(self.drag == default.drag, self.drag.into()))
            .with("amounts", self.amounts.clone())
            .with_some("end_amounts", self.end_amounts.clone())
            .with_some("bead", unless(self.bead == default.bead, self.bead.into()))
            .with_some("scraped", unless(self.scraped == default.scraped, self.scraped.into()));
        Node::Inline(tree)
    }
}
