//! One photograph after another is painted.

use std::cell::Cell;
use std::time::Instant;

use girtin::grid::Raster;
use girtin::painting::picture::write_picture;
use girtin::painting::{ContactSheet, PaintError, ResolveError, Stock};
use girtin::watercolorize::{Painting, PhotoError, Request, Stage, Watch, watercolorize};
use serde_json::{Value, json};

use crate::arguments::MeansArgs;
use crate::failure::Failure;
use crate::input;
use crate::interrupt::Interrupt;
use crate::output::print;
use crate::progress::Stages as Progress;

use super::asked::Recipe;
use super::c97::Mattes;
use super::deliver::{Delivered, Delivery, bytes};
use super::outputs::Errand;
use super::photo::{MaskArgs, Opened, Reading};
use super::plan::Plan;
use super::told::Told;

/// What every painting of a command shares.
#[derive(Debug)]
pub struct Work<'a> {
    /// How they are painted: one recipe, or those of a contact sheet.
    pub recipes: &'a [Recipe],
    pub is_contact_sheet: bool,
    pub stock: &'a Stock,
    pub masks: &'a MaskArgs,
    pub reading: Reading,
    pub json: bool,
    pub means: MeansArgs,
    pub interrupt: &'a Interrupt,
}

/// The photograph with its masks.
#[derive(Debug)]
pub struct Material {
    /// Light.
    pub photo: Raster<[f32; 3]>,
    /// Columns and rows that it had.
    pub size: [usize; 2],
    masks: [Option<Raster<f32>>; 2],
    /// Long edge of the picture, pixels.
    pub long_edge: u32,
}

/// Pixels a millimetre that a document can say.
const RESOLUTIONS: std::ops::RangeInclusive<f64> = 0.01..=100.0;

/// # Errors
/// The painting is to be saved, and a document cannot say so many pixels a millimetre.
fn check_resolution(errand: &Errand, plan: &Plan<'_>) -> Result<(), Failure> {
    if errand.save.is_some() && !RESOLUTIONS.contains(&plan.pixels_per_mm()) {
        let message = format!("a document cannot have {:.3} pixels a mm", plan.pixels_per_mm());
        return Err(Failure::usage(message).hint("choose another `--sheet` or `--size`"));
    }
    Ok(())
}

/// What to do about too little memory.
const SMALLER: &str = "give a smaller `--size`, or `--detail low`";

impl Work<'_> {
    /// Says what would be done with a photograph, which is read for that: half a file is not to look fine.
    ///
    /// # Errors
    /// It, a mask or a matte cannot be read.
    pub fn plan(&self, errand: &Errand) -> Result<(), Failure> {
        let opened = self.reading.open(&errand.photo)?;
        let (photo, long_edge) = (opened.size, opened.long_edge);
        let recipes = self.recipes_for(&opened);
        let plan = |recipe| Plan { recipe, photo, long_edge, errand };
        recipes.iter().try_for_each(|recipe| check_resolution(errand, &plan(recipe)))?;
        if let Some(mattes) = &errand.mattes {
            self.tell_unused(mattes);
            mattes.check(photo)?;
        }
        drop(self.material(errand, opened)?);
        for plan in recipes.iter().map(plan) {
            print(&if self.json { format!("{}\n", plan.json()) } else { plan.text() })?;
        }
        Ok(())
    }

    fn recipes_for(&self, photo: &Opened) -> Vec<Recipe> {
        self.recipes.iter().map(|recipe| recipe.for_photo(photo)).collect()
    }

    fn tell_unused(&self, mattes: &Mattes) {
        for path in mattes.unused() {
            let name = path.display();
            self.means
                .talk
                .say(&format!("girtin: `{name}` is not painted: `--glazes` has no matte of its name"));
        }
    }

    /// Paints a photograph and writes what is to be written of it.
    ///
    /// # Errors
    /// It cannot be read, painted or written, or it was interrupted.
    pub fn paint(&self, errand: &Errand, title: &str) -> Result<(), Failure> {
        let start = Instant::now();
        let name = errand.photo.display().to_string();
        let progress = self.means.talk.stages(&name, title);
        let done = self.painted(errand, &progress);
        progress.end();
        let (size, more, delivered) = done?;
        self.interrupt.check()?;
        for staged in delivered.staged {
            staged.commit()?;
        }
        if let Some(difference) = delivered.difference {
            self.means.talk.say(&format!(
                "girtin: layers put together differ from the painting by {:.3} of 255 in the mean, {} at most",
                difference.mean, difference.max
            ));
        }
        let seconds = start.elapsed().as_secs_f64();
        self.means.talk.detail(&format!("{}: {seconds:.1} s", input::name_of(&errand.photo)));
        if self.json {
            print(&Told::line(&errand.photo, errand.output(), size, &more, seconds))
        } else {
            Ok(())
        }
    }

    /// Everything but names for the outputs: the picture's size, what is told of it, and what was written.
    fn painted(
        &self,
        errand: &Errand,
        progress: &Progress,
    ) -> Result<([usize; 2], Value, Delivered), Failure> {
        progress.at("reading the photograph", 0.0);
        let opened = self.reading.open(&errand.photo)?;
        let (photo, long_edge) = (opened.size, opened.long_edge);
        let recipes = self.recipes_for(&opened);
        let plan = |recipe| Plan { recipe, photo, long_edge, errand };
        let plans: Vec<Plan<'_>> = recipes.iter().map(plan).collect();
        self.tell(errand, &plans[0]);
        check_resolution(errand, &plans[0])?;
        let most = plans.iter().map(Plan::memory).max().unwrap_or(0);
        self.means.check_memory(most, SMALLER)?;
        let material = self.material(errand, opened)?;
        if self.is_contact_sheet {
            return self.contact_sheet(errand, &recipes, &material, progress);
        }
        let [painting, developing] = plans[0].seconds();
        let done = painting / (painting + developing);
        let recipe = &recipes[0];
        let (painting, planned) = match &errand.mattes {
            Some(mattes) => {
                let (painting, planned) = mattes.paint(self, recipe, &material, progress, done)?;
                (painting, Some(planned))
            }
            None => {
                let say = |stage, part| progress.at(said(stage), done * part);
                (self.carry_out(recipe, &material, &say)?, None)
            }
        };
        drop(material);
        let delivery = Delivery {
            painting: &painting,
            stock: self.stock,
            picture: self.means.write.picture,
            interrupt: self.interrupt,
            progress,
            done,
            developed: Cell::new(0),
            developments: Delivery::developments_for(errand, painting.painted.glazes.len()),
        };
        let mut delivered = delivery.write(errand)?;
        if let (Some(targets), Some(planned)) = (&errand.targets, &planned) {
            delivered.staged.extend(targets.write(planned)?);
        }
        let told = Told::of(recipe, &painting.document, &painting.painted.glazes);
        self.means.talk.detail(&format!("pigments: {}", told.palette().join(", ")));
        let mut more = told.json();
        if let (Some(mattes), Some(more)) = (&errand.mattes, more.as_object_mut()) {
            let unused = mattes.unused().iter().map(|path| path.display().to_string());
            more.insert("unused_mattes".to_owned(), unused.collect());
        }
        if let (Some(difference), Some(more)) = (&delivered.difference, more.as_object_mut()) {
            let difference = json!({ "mean": difference.mean, "max": difference.max });
            more.insert("layers_difference".to_owned(), difference);
        }
        Ok((painting.painted.sheet.picture, more, delivered))
    }

    fn tell(&self, errand: &Errand, plan: &Plan<'_>) {
        if let Some(mattes) = &errand.mattes {
            self.tell_unused(mattes);
        }
        self.means.talk.detail(&plan.text());
        let longest = plan.photo[0].max(plan.photo[1]);
        if self.reading.size.is_none() && !self.reading.is_preview && longest > plan.long_edge as usize {
            self.means.talk.detail(&format!(
                "the painting is {} pixels long and the photograph {longest}: `--size` makes it larger",
                plan.long_edge
            ));
        }
    }

    fn material(&self, errand: &Errand, opened: Opened) -> Result<Material, Failure> {
        let (size, long_edge) = (opened.size, opened.long_edge);
        // Masks are small, and a wrong one is to be said before the photograph is decoded.
        let masks = self.masks.read(&errand.naming(), opened.size)?;
        self.interrupt.check()?;
        Ok(Material { photo: opened.read(self.means.talk)?, size, masks, long_edge })
    }

    fn carry_out(
        &self,
        recipe: &Recipe,
        material: &Material,
        progress: &(dyn Fn(Stage, f64) + Sync),
    ) -> Result<Painting, Failure> {
        self.interrupt.check()?;
        let [reserve, detail_map] = &material.masks;
        let request = Request {
            photo: &material.photo,
            pixels: material.size,
            params: &recipe.params,
            palette: recipe.palette.as_deref(),
            paper: &recipe.paper,
            mounting: recipe.mounting,
            seed: recipe.seed(),
            long_edge: material.long_edge,
            reserve: reserve.as_ref(),
            detail_map: detail_map.as_ref(),
            focus: recipe.focus,
            // A file's name is the photographer's own affair.
            title: "",
        };
        let watch = Watch { cancel: Some(self.interrupt.flag()), progress: Some(progress) };
        watercolorize(&request, self.stock, &watch).map_err(|error| self.failed(&error))
    }

    /// A painting by each recipe, side by side.
    fn contact_sheet(
        &self,
        errand: &Errand,
        recipes: &[Recipe],
        material: &Material,
        progress: &Progress,
    ) -> Result<([usize; 2], Value, Delivered), Failure> {
        let mut sheet: Option<ContactSheet> = None;
        let mut told = Vec::new();
        let count = recipes.len();
        for (at, recipe) in recipes.iter().enumerate() {
            let part = |part: f64| (at as f64 + part) / count as f64;
            let say = |stage, done| {
                let stage = format!("{}: {}", recipe.preset, said(stage));
                progress.at(&stage, part(0.9 * done));
            };
            let painting = self.carry_out(recipe, material, &say)?;
            let picture = painting.painted.development().encoded(bytes);
            let size = [picture.width(), picture.height()];
            let sheet = sheet.get_or_insert_with(|| ContactSheet::new(count, size, GROUND));
            sheet.lay(&picture, &recipe.preset);
            told.push(Told::of(recipe, &painting.document, &painting.painted.glazes).json());
        }
        let names: Vec<&str> = recipes.iter().map(|recipe| recipe.preset.as_str()).collect();
        self.means.talk.detail(&format!("in this order: {}", names.join(", ")));
        let picture = sheet.map_or_else(|| Raster::new(1, 1, GROUND), ContactSheet::into_picture);
        let size = [picture.width(), picture.height()];
        let mut delivered = Delivered::default();
        if let Some((target, format)) = &errand.picture {
            let words = [("Seed", recipes[0].seed().to_string())];
            let meta = self.means.write.picture.meta(None, &words);
            let write =
                |writer: &mut dyn std::io::Write| Ok(write_picture(writer, &picture, *format, &meta)?);
            delivered.staged.push(target.stage(write)?);
        }
        Ok((size, json!({ "paintings": told }), delivered))
    }

    fn failed(&self, error: &PhotoError) -> Failure {
        if let Err(interrupted) = self.interrupt.check() {
            return interrupted;
        }
        match error {
            PhotoError::Cancelled => self.interrupt.failure(),
            PhotoError::Pigment(unknown) => Failure::usage(unknown).hint(unknown.hint()),
            PhotoError::Palette(_) => Failure::usage(error).hint("name fewer pigments, or at least one"),
            PhotoError::Resolve(ResolveError::TooLarge { .. } | ResolveError::NoRoom(_))
            | PhotoError::Paint(PaintError::Resolve(
                ResolveError::TooLarge { .. } | ResolveError::NoRoom(_),
            )) => Failure::failed(error).hint(SMALLER),
            PhotoError::Resolve(_) => Failure::failed(error).hint("choose another `--sheet`"),
            _ => Failure::failed(error).hint("try another `--seed` or fewer `--washes`"),
        }
    }
}

/// What paintings on a contact sheet lie on.
const GROUND: [u8; 3] = [231, 230, 227];

/// A stage in words.
fn said(stage: Stage) -> &'static str {
    match stage {
        Stage::Looking => "looking at the photograph",
        Stage::Planning => "planning values, masses and marks",
        Stage::Palette => "choosing pigments",
        Stage::Washing => "washes run and dry",
    }
}
