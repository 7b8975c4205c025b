//! Trains the terrain model: a sliced-Wasserstein autoencoder (Kolouri et al. 2018) on elevation tiles.
//!
//! The encoder turns a tile into a field of latent numbers, the decoder turns them back. Three things are made small: the error
//! of that; the sliced Wasserstein distance of the codes from the normal distribution, jointly for blocks of cells, so that
//! a field of independent normal numbers is a latent field too; and the sliced distance between patches of surfaces decoded
//! from such fields and patches of real tiles, which keeps them from being blurred. Afterwards the octaves and the steepness of
//! what the decoder draws are fitted to the training scans.

mod adam;
mod card;
mod error;
mod finish;
mod loss;
mod network;
mod ops;
mod trainer;

use std::path::{Path, PathBuf};

use vb_terrain::data::{Data, Meaning};
use vb_terrain::model::Model;
use vb_terrain::tiles::Tiles;

pub use card::{Card, DataCard, Look, Metrics};
pub use error::TrainError;
pub use trainer::{End, Losses, Progress, Settings};

use trainer::{CUT, Trainer, checkpoint_of};

#[derive(Clone, Debug)]
pub struct Options {
    /// Folder of elevation data.
    pub data: PathBuf,
    /// File that says which parts of it to use; without, `terrain.yaml` in the folder, if it is there.
    pub selection: Option<PathBuf>,
    pub meaning: Meaning,
    /// Standard deviation of height at full relief, m; without, that of the data.
    pub relief: Option<f64>,
    /// Share of the noise that surfaces are drawn with, from 0 to 1.
    pub detail: f64,
    /// Where the model goes; its card goes beside it as `.json`.
    pub out: PathBuf,
    pub settings: Settings,
    pub end: End,
    /// Whether to go on from the checkpoint beside the model.
    pub resume: bool,
}

/// What can be told while a training goes on.
#[derive(Clone, Debug)]
pub enum Event<'a> {
    /// The data are read.
    Data(&'a DataCard),
    /// A training is taken up after so many steps.
    Resumed(u64),
    Progress(&'a Progress),
}

/// Trains a model, writes it and its card, and removes the checkpoint.
pub fn train(options: &Options, mut tell: impl FnMut(Event)) -> Result<Card, TrainError> {
    let data = Data::read(&options.data, options.selection.as_deref(), options.meaning)?;
    let tiles = Tiles::cut(data.scans.iter().filter(|s| !s.held_out), CUT);
    if tiles.is_empty() {
        return Err(TrainError::TooLittle(format!(
            "no file has a whole tile of {side} x {side} samples (at --every {})",
            options.meaning.every,
            side = CUT.side
        )));
    }
    let of_data = DataCard::new(&data, &tiles);
    tell(Event::Data(&of_data));
    let checkpoint = checkpoint_of(&options.out);
    let mut trainer = Trainer::new(&tiles, &data.sha256, options.settings, checkpoint.clone())?;
    if options.resume {
        trainer.resume()?;
        tell(Event::Resumed(trainer.step));
    }
    let (losses, seconds) = trainer.run(options.end, |p| tell(Event::Progress(p)))?;
    let weights = card::weights(&trainer.network)?;
    let relief = options.relief.unwrap_or(data.std);
    let trained = || data.scans.iter().filter(|s| !s.held_out);
    let (header, passes) =
        finish::finish(&weights, &tiles, trained(), data.resolution, relief, options.detail)?;
    let bytes = Model::encode(header, &weights, &passes).map_err(TrainError::Internal)?;
    let any = data.scans.iter().any(|s| s.held_out);
    let test: Vec<_> = data.scans.iter().filter(|s| s.held_out == any).collect();
    let held_out = card::measure(&trainer.network, &header, &weights, &passes, &test)?;
    let trained_on = card::look_of_scans(&trained().collect::<Vec<_>>(), &header);
    let sha256 = vb_files::sha256(&bytes);
    let card = Card {
        schema: 2,
        sha256,
        data: of_data,
        settings: options.settings,
        steps: trainer.step,
        seconds: seconds.round(),
        losses,
        header,
        trained_on,
        held_out,
    };
    error::write(&options.out, &bytes)?;
    let text = serde_json::to_string_pretty(&card).map_err(|e| TrainError::Internal(e.to_string()))?;
    error::write(&card_of(&options.out), (text + "\n").as_bytes())?;
    // The model is there: what is left of the checkpoint does no harm.
    let _ = std::fs::remove_file(checkpoint);
    Ok(card)
}

#[must_use]
pub fn card_of(model: &Path) -> PathBuf {
    model.with_extension("json")
}
