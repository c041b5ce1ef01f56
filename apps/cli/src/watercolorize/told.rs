//! What is told of a painting, for people and programs.

use std::path::Path;

use girtin::painting::{Document, PaintedGlaze};
use serde_json::{Value, json};

use super::asked::Recipe;

/// A painting, to be told of after it is gone.
#[derive(Clone, Debug)]
pub struct Told {
    preset: String,
    seed: u64,
    palette: Vec<String>,
    glazes: Vec<Value>,
}

impl Told {
    /// Of a painting.
    pub fn of(recipe: &Recipe, document: &Document, painted: &[PaintedGlaze]) -> Self {
        let mut palette: Vec<String> = Vec::new();
        for pigment in document.glazes.iter().flat_map(|glaze| &glaze.pigments) {
            if !palette.contains(pigment) {
                palette.push(pigment.clone());
            }
        }
        let glazes = document.glazes.iter().zip(painted).map(|(glaze, painted)| {
            let pigments = painted.pigments.iter().map(|balance| {
                json!({
                    "name": balance.name,
                    "laid": balance.laid,
                    "lifted": balance.lifted,
                    "total": balance.total,
                })
            });
            json!({ "name": glaze.name, "pigments": pigments.collect::<Vec<_>>() })
        });
        Self { preset: recipe.preset.clone(), seed: recipe.seed(), palette, glazes: glazes.collect() }
    }

    /// Ids of its pigments.
    pub fn palette(&self) -> &[String] {
        &self.palette
    }

    /// As JSON, without what is the picture's.
    pub fn json(&self) -> Value {
        json!({ "preset": self.preset, "seed": self.seed, "palette": self.palette, "glazes": self.glazes })
    }

    /// A line of JSON of a picture that was written; what `more` says joins it.
    pub fn line(input: &Path, output: Option<&str>, size: [usize; 2], more: &Value, seconds: f64) -> String {
        let mut object = json!({
            "input": input.display().to_string(),
            "output": output,
            "width": size[0],
            "height": size[1],
        });
        if let (Some(object), Some(more)) = (object.as_object_mut(), more.as_object()) {
            object.extend(more.clone());
            object.insert("seconds".to_owned(), json!((seconds * 1e3).round() / 1e3));
        }
        format!("{object}\n")
    }
}
