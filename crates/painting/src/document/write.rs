//! A document as text: every value is written, in one description for TOML and JSON.

use girtin_optics::{LinearRgb, Srgb};
use girtin_params::write::{Node, Tree};
use girtin_wash::WashModel;

use super::{Document, Event, FORMAT, Feed, Figure, Glaze, MapName, Mark, Outline, SheetSettings};
use crate::area::{Area, Shape};

impl Document {
    /// The document as TOML, which [`Document::from_toml`] reads as an equal one.
    pub fn to_toml(&self) -> String {
        self.tree().to_toml()
    }

    /// The same as JSON, for [`Document::from_json`].
    pub fn to_json(&self) -> String {
        self.tree().to_json()
    }

    fn tree(&self) -> Tree {
        let drawing = self.drawing.iter().map(Figure::tree).collect::<Vec<_>>();
        let drawing = (!drawing.is_empty()).then_some(Node::Sections(drawing));
        Tree::new()
            .with("format", FORMAT)
            .with("title", self.title.as_str())
            .with("sheet", Node::Section(self.sheet.tree()))
            .with_some("drawing", drawing)
            .with("glaze", Node::Sections(self.glazes.iter().map(Glaze::tree).collect()))
    }
}

impl SheetSettings {
    fn tree(&self) -> Tree {
        let printed = self.printed.iter();
        let printed = printed
            .map(|(color, area)| Tree::new().with("color", of_color(*color)).with("area", area.node()));
        Tree::new()
            .with("size", self.size_mm)
            .with("paper", self.paper.as_str())
            .with("seed", self.seed)
            .with("ground", of_color(self.ground))
            .with("pixels_per_mm", self.pixels_per_mm)
            .with("cells_per_pixel", self.cells_per_pixel)
            .with_some("cells_per_mm", self.cells_per_mm)
            .with("trim", self.trim_mm)
            .with("relief", self.relief_mm)
            .with("printed", Node::Sections(printed.collect()))
    }
}

/// `#rrggbb` where that is the color exactly, else its light.
fn of_color(color: LinearRgb) -> Node {
    let nearest = Srgb::from_bytes(color.to_srgb().to_bytes());
    if nearest.to_linear() == color {
        return nearest.to_string().as_str().into();
    }
    Node::Inline(Tree::new().with("linear", color.0))
}

impl Glaze {
    fn tree(&self) -> Tree {
        let pigments: Vec<&str> = self.pigments.iter().map(String::as_str).collect();
        Tree::new()
            .with("name", self.name.as_str())
            .with("pigments", pigments)
            .with("granulation", self.granulation)
            .with("wash", Node::Section(of_model(&self.model)))
            .with_some("outline", self.outline.as_ref().map(|outline| Node::Section(outline.tree())))
            .with("events", Node::Sections(self.events.iter().map(Event::tree).collect()))
    }
}

fn of_model(model: &WashModel) -> Tree {
    match model {
        WashModel::C97 { params, capillary } => {
            let layer = capillary.as_ref().map(|capillary| Node::Section(Tree::of_parameters(capillary)));
            Tree::new().with("model", "c97").and(Tree::of_parameters(params)).with_some("capillary", layer)
        }
        WashModel::Living(params) => {
            Tree::new().with("model", "living").with("living", Node::Section(Tree::of_parameters(params)))
        }
    }
}

impl Outline {
    fn tree(&self) -> Tree {
        let file = |name: &MapName| Node::from(name.file.as_str());
        Tree::new()
            .with("regions", file(&self.regions))
            .with_some("edges", self.edges.as_ref().map(file))
            .with_some("masked", self.masked.as_ref().map(file))
    }
}

impl Event {
    fn tree(&self) -> Tree {
        let does = |what: &str| Tree::new().with("do", what);
        let amounts = |amounts: &Vec<f64>| Node::from(amounts.clone());
        match self {
            Self::Wet { area } => does("wet").with("area", area.node()),
            Self::Water { area, amount } => does("water").with("area", area.node()).with("amount", *amount),
            Self::Pigment { area, amounts: of_each } => {
                does("pigment").with("area", area.node()).with("amounts", amounts(of_each))
            }
            Self::Brush { area, water, amounts: of_each } => does("brush")
                .with("area", area.node())
                .with("water", *water)
                .with("amounts", amounts(of_each)),
            Self::Fill(fill) => fill.tree(does("fill")),
            Self::Marks { marks, rim } => does("marks")
                .with("rim", *rim)
                .with("marks", Node::List(marks.iter().map(Mark::node).collect())),
            Self::Moisten { area, volumes } => {
                does("moisten").with("area", area.node()).with("volumes", *volumes)
            }
            Self::Blot { area, fraction } => {
                does("blot").with("area", area.node()).with("fraction", *fraction)
            }
            Self::Tilt { degrees, toward } => does("tilt").with("degrees", *degrees).with("toward", *toward),
            Self::Run { steps, until_dry, feed } => does("run")
                .with("steps", *steps)
                .with_some("until", until_dry.then_some("dry"))
                .with_some("feed", feed.as_ref().map(Feed::node)),
            Self::Lift { area, fraction } => {
                does("lift").with("area", area.node()).with("fraction", *fraction)
            }
            // Dampness is of the whole wash.
            Self::Dry { area: Some(area), .. } => does("dry").with("area", area.node()),
            Self::Dry { area: None, damp } => does("dry").with("damp", *damp),
        }
    }
}

impl Feed {
    fn node(&self) -> Node {
        let tree = Tree::new().with("area", self.area.node());
        Node::Inline(tree.with("amount", self.amount).with("level", self.level))
    }
}

impl Area {
    fn node(&self) -> Node {
        let shape = |name: &str| Tree::new().with("shape", name);
        let points = |points: &[[f64; 2]]| Node::List(points.iter().map(|&point| point.into()).collect());
        let tree = match &self.shape {
            Shape::Everywhere => shape("everywhere"),
            Shape::Disc { center, radius } => shape("disc").with("center", *center).with("radius", *radius),
            Shape::Rectangle { from, to } => shape("rectangle").with("from", *from).with("to", *to),
            Shape::Polygon { points: corners } => shape("polygon").with("points", points(corners)),
            Shape::Stroke { points: path, width: [begin, end] } => {
                shape("stroke").with("points", points(path)).with("width", *begin).with("end_width", *end)
            }
            Shape::Map(name) => shape("map").with("file", name.file.as_str()),
        };
        Node::Inline(
            tree.with("soft", self.soft_mm)
                .with("ragged", self.ragged_mm)
                .with("ragged_scale", self.ragged_scale_mm)
                .with("above_height", self.above_height)
                .with("bristles", self.bristles),
        )
    }
}

#[cfg(test)]
mod tests;
