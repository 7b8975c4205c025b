//! A world as the bytes of its files.

use super::documents::{
    BedsDocument, ObstaclesDocument, SemanticsDocument, TasksDocument, WorldDocument, check_schema,
};
use super::error::SuiteError;
use super::{elevation, text};
use crate::World;
use crate::check::{Flaw, Part};
use std::path::Path;
use vb_files::Hash;

/// Largest file of a world that is read, bytes: the picture of the largest world there may be has 128 MiB at most.
const MAX_BYTES: u64 = 256 << 20;

/// The files of a world, in the order of [`Part::ALL`]. One that the world doesn't have is empty.
pub(crate) struct WorldFiles([Vec<u8>; Part::ALL.len()]);

impl WorldFiles {
    pub(crate) fn from_world(world: &World) -> Result<Self, Flaw> {
        if world.scale != 1.0 {
            let problem = format!("{} cannot be stored: worlds are stored at scale 1", world.scale);
            return Err(Flaw::new(Part::World, "scale", problem));
        }
        world.check()?;
        let (range, levels) = world.heightfield.to_levels();
        let h = &world.heightfield;
        Ok(Self([
            WorldDocument::write(world, range).into_bytes(),
            elevation::encode(h.rows(), h.cols(), &levels),
            SemanticsDocument::write(&world.semantics).into_bytes(),
            ObstaclesDocument::write(&world.obstacles).into_bytes(),
            TasksDocument::write(&world.tasks).into_bytes(),
            BedsDocument::write(&world.beds).into_bytes(),
        ]))
    }

    pub(crate) fn read(folder: &Path) -> Result<Self, SuiteError> {
        let mut files = Self(Default::default());
        for (part, slot) in Part::ALL.iter().zip(&mut files.0) {
            let path = folder.join(part.file_name());
            if *part == Part::Beds && !path.exists() {
                continue;
            }
            *slot = vb_files::read(&path, MAX_BYTES).map_err(|source| SuiteError::Read {
                path,
                hint: "each world needs world.yaml, elevation.png, semantics.yaml, obstacles.yaml and tasks.yaml",
                source,
            })?;
            if *part == Part::Beds && slot.is_empty() {
                return Err(SuiteError::invalid(
                    &folder.join(part.file_name()),
                    "beds",
                    "the file is empty: restore it, or remove it from a world without beds",
                ));
            }
        }
        Ok(files)
    }

    /// The files that the world has.
    fn there(&self) -> impl Iterator<Item = (&Part, &Vec<u8>)> {
        Part::ALL.iter().zip(&self.0).filter(|(part, bytes)| **part != Part::Beds || !bytes.is_empty())
    }

    /// Writes the files into a world's folder, which is made.
    pub(crate) fn write(&self, folder: &Path) -> Result<(), SuiteError> {
        std::fs::create_dir_all(folder).map_err(|e| SuiteError::write(folder, e))?;
        for (part, bytes) in self.there() {
            let path = folder.join(part.file_name());
            std::fs::write(&path, bytes).map_err(|e| SuiteError::write(&path, e))?;
        }
        Ok(())
    }

    /// SHA-256, in hexadecimal, over name, length and content of every file. The content of the elevation image is its size and its
    /// levels, so that the compressor does not matter. Line ends count as LF: a checkout that turned them into CR LF is the same world.
    pub(crate) fn hash(&self) -> String {
        let mut hasher = Hash::new();
        for (part, bytes) in self.there() {
            let unified = match part {
                // What is no image has some other hash, whatever it is.
                Part::Elevation => elevation::content(bytes),
                _ if !bytes.contains(&b'\r') => None,
                _ => Some(String::from_utf8_lossy(bytes).replace("\r\n", "\n").into_bytes()),
            };
            let content = unified.as_ref().unwrap_or(bytes);
            hasher.update(part.file_name().as_bytes());
            hasher.update([0]);
            hasher.update((content.len() as u64).to_le_bytes());
            hasher.update(content);
        }
        hasher.hex()
    }

    /// The world that the files hold, checked. `folder` is for messages.
    pub(crate) fn to_world(&self, folder: &Path) -> Result<World, SuiteError> {
        let world = self.parse(folder)?;
        world.check().map_err(|f| SuiteError::flaw(folder, f))?;
        Ok(world)
    }

    /// The world that the files hold, whose values may make no sense. `folder` is for messages.
    pub(crate) fn parse(&self, folder: &Path) -> Result<World, SuiteError> {
        let [world, image, semantics, obstacles, tasks, beds] = &self.0;
        let flaw = |f| SuiteError::flaw(folder, f);
        let (file, yaml) = document(folder, Part::World, world)?;
        check_schema(&file, yaml)?;
        let world: WorldDocument = text::parse(&file, yaml)?;
        world.check().map_err(flaw)?;
        let grid = &world.grid;
        let heightfield = elevation::decode(image, grid.rows, grid.cols, grid.resolution, grid.height_range)
            .map_err(flaw)?;
        let (file, yaml) = document(folder, Part::Semantics, semantics)?;
        let semantics = text::parse::<SemanticsDocument>(&file, yaml)?.into_semantics().map_err(flaw)?;
        let (file, yaml) = document(folder, Part::Obstacles, obstacles)?;
        let obstacles = text::parse::<ObstaclesDocument>(&file, yaml)?.into_obstacles().map_err(flaw)?;
        let (file, yaml) = document(folder, Part::Tasks, tasks)?;
        let tasks = text::parse::<TasksDocument>(&file, yaml)?.tasks;
        let beds = if beds.is_empty() {
            Vec::new()
        } else {
            let (file, yaml) = document(folder, Part::Beds, beds)?;
            text::parse::<BedsDocument>(&file, yaml)?.into_beds().map_err(flaw)?
        };
        let WorldDocument { id, elevation, terrain, density, .. } = world;
        Ok(World {
            id,
            elevation,
            terrain,
            density,
            scale: 1.0,
            heightfield,
            semantics,
            obstacles,
            tasks,
            beds,
        })
    }
}

/// The text of a document, with its place.
fn document<'a>(
    folder: &Path,
    part: Part,
    bytes: &'a [u8],
) -> Result<(std::path::PathBuf, &'a str), SuiteError> {
    let file = folder.join(part.file_name());
    match std::str::from_utf8(bytes) {
        Ok(text) => Ok((file, text)),
        Err(e) => Err(SuiteError::invalid(
            &file,
            format!("byte {}", e.valid_up_to()),
            "is not UTF-8 text: restore the file",
        )),
    }
}
