//! A suite: a folder of worlds with an index.

use super::documents::check_schema;
use super::error::{SuiteError, list};
use super::world_files::WorldFiles;
use super::{SCHEMA, text};
use crate::check::check_id;
use crate::{Density, Elevation, Terrain, World};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use vb_files::Hash;

/// The origin of the worlds of a suite.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Provenance {
    /// The worlds were made by a generator: the same generator, seed and parameters make the same bytes again.
    Generated {
        /// The name and the version of the generator.
        generator: String,
        /// The seed of the generator.
        seed: u64,
    },
    /// The worlds were read from data of another format.
    Imported {
        /// The data that were imported.
        source: String,
        /// The place of the worlds on the Earth, if the data say so.
        #[serde(default)]
        place: Option<Georeference>,
    },
    /// The worlds were made manually.
    Authored {
        /// The people who made them, or the way in which they did.
        by: String,
    },
}

/// The place of the worlds of a suite on the Earth.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Georeference {
    /// The name of the coordinate reference system, such as EPSG:32632.
    pub crs: String,
    /// The definition of the system as a string of PROJ; none if it is unknown.
    #[serde(default)]
    pub proj: Option<String>,
    /// Metres on the ground for a unit of its coordinates along x (east) and y (north).
    pub metres: [f64; 2],
    /// The coordinates of the middle of each world in that system.
    pub origins: BTreeMap<String, [f64; 2]>,
}

impl Georeference {
    /// The coordinates in the system of a place in a world, m east and north of its middle; `None` if the world has no origin.
    #[must_use]
    pub fn at(&self, world: &str, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let origin = self.origins.get(world)?;
        Some([origin[0] + x / self.metres[0], origin[1] + y / self.metres[1]])
    }

    fn check(&self) -> Result<(), (String, String)> {
        if !self.metres.iter().all(|m| m.is_finite() && *m > 0.0) {
            let [x, y] = self.metres;
            return Err(("provenance.imported.place.metres".into(), format!("[{x}, {y}] must be above 0")));
        }
        match self.origins.iter().find(|(_, at)| !at.iter().all(|v| v.is_finite())) {
            Some((world, _)) => {
                Err((format!("provenance.imported.place.origins.{world}"), "must be two numbers".into()))
            }
            None => Ok(()),
        }
    }
}

/// What a suite says about itself.
#[derive(Clone, Debug, PartialEq)]
pub struct SuiteMeta {
    /// The short name of the suite.
    pub name: String,
    /// The version of the suite, as free text.
    pub version: String,
    /// A description of the suite, for people.
    pub description: String,
    /// The origin of the suite's worlds.
    pub provenance: Provenance,
}

/// A world of the index.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldInfo {
    /// The name of the world, which is also that of its folder.
    pub id: String,
    /// The elevation level of the world.
    pub elevation: Elevation,
    /// The terrain type of the world.
    pub terrain: Terrain,
    /// The obstacle density of the world.
    pub density: Density,
    /// The names of the world's tasks, in order.
    pub tasks: Vec<String>,
    /// The content hash: the SHA-256 over all files of the world.
    pub sha256: String,
}

/// The index of a suite.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SuiteDocument {
    #[serde(rename = "schema")]
    _schema: u32,
    /// The short name of the suite.
    name: String,
    /// The version of the suite, free text.
    version: String,
    /// A description of the suite.
    description: String,
    /// The origin of the worlds.
    provenance: Provenance,
    /// The worlds, in the order in which they are run.
    worlds: Vec<WorldInfo>,
}

/// An opened suite: its index. Worlds are read when they are asked for.
#[derive(Clone, Debug)]
pub struct Suite {
    dir: PathBuf,
    meta: SuiteMeta,
    worlds: Vec<WorldInfo>,
}

const INDEX: &str = "suite.yaml";

impl Suite {
    /// Reads the index of the suite in `dir`.
    ///
    /// # Errors
    /// Returns an error if `suite.yaml` is missing, unreadable, of another schema version, or invalid.
    pub fn open(dir: impl AsRef<Path>) -> Result<Self, SuiteError> {
        let dir = dir.as_ref().to_path_buf();
        let file = dir.join(INDEX);
        let yaml = vb_files::read_text(&file, vb_files::DOCUMENT).map_err(|source| SuiteError::Read {
            path: file.clone(),
            hint: "name a suite's folder, one that holds suite.yaml",
            source,
        })?;
        check_schema(&file, &yaml)?;
        let SuiteDocument { name, version, description, provenance, worlds, .. } = text::parse(&file, &yaml)?;
        check_index(&worlds).map_err(|(field, problem)| SuiteError::invalid(&file, field, problem))?;
        if let Provenance::Imported { place: Some(place), .. } = &provenance {
            place.check().map_err(|(field, problem)| SuiteError::invalid(&file, field, problem))?;
        }
        Ok(Self { dir, meta: SuiteMeta { name, version, description, provenance }, worlds })
    }

    /// Writes a suite into `dir`, which must not exist or be empty, and opens it.
    ///
    /// # Errors
    /// Returns an error if the directory holds something, cannot be written, or a world has a flaw.
    pub fn write<'a>(
        dir: impl AsRef<Path>,
        meta: &SuiteMeta,
        worlds: impl IntoIterator<Item = &'a World>,
    ) -> Result<Self, SuiteError> {
        let mut writer = SuiteWriter::create(dir, meta.clone())?;
        for world in worlds {
            writer.add(world)?;
        }
        writer.finish()
    }

    /// The folder of the suite.
    #[must_use]
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// What the suite says about itself.
    #[must_use]
    pub fn meta(&self) -> &SuiteMeta {
        &self.meta
    }

    /// The folder of a world, whether it is there or not.
    #[must_use]
    pub fn world_dir(&self, id: &str) -> PathBuf {
        world_folder(&self.dir, id)
    }

    /// The worlds of the index, in order.
    #[must_use]
    pub fn worlds(&self) -> &[WorldInfo] {
        &self.worlds
    }

    /// Tells whether a world has granular beds.
    #[must_use]
    pub fn has_beds(&self, id: &str) -> bool {
        self.world_dir(id).join(crate::Part::Beds.file_name()).exists()
    }

    /// What the index says about a world.
    ///
    /// # Errors
    /// Returns an error if there is no such world.
    pub fn world_info(&self, id: &str) -> Result<&WorldInfo, SuiteError> {
        self.worlds.iter().find(|w| w.id == id).ok_or_else(|| SuiteError::UnknownWorld {
            file: self.dir.join(INDEX),
            world: id.into(),
            known: list(&self.worlds.iter().map(|w| w.id.as_str()).collect::<Vec<_>>()),
        })
    }

    /// A world that has the same content as one of another suite: this one's, and the other's.
    #[must_use]
    pub fn common_world<'a>(&'a self, other: &'a Self) -> Option<(&'a WorldInfo, &'a WorldInfo)> {
        other.worlds.iter().find_map(|theirs| {
            let own = self.worlds.iter().find(|w| w.sha256 == theirs.sha256)?;
            Some((own, theirs))
        })
    }

    /// The number of tasks in all worlds.
    #[must_use]
    pub fn task_count(&self) -> usize {
        self.worlds.iter().map(|w| w.tasks.len()).sum()
    }

    /// Reads a world and checks its content hash and every value.
    ///
    /// # Errors
    /// Returns an error if there is no such world, a file is missing or invalid, or the files are not those of the
    /// index.
    pub fn load_world(&self, id: &str) -> Result<World, SuiteError> {
        let info = self.world_info(id)?;
        let folder = world_folder(&self.dir, id);
        let files = WorldFiles::read(&folder)?;
        // Content first: its message says what is wrong, where the hash only says that something is.
        let world = files.to_world(&folder)?;
        self.agrees(info, &world, files.hash())?;
        Ok(world)
    }

    /// Reads a world for all that is wrong with it, where [`Suite::load_world`] stops at the first error. The world is
    /// returned with the errors if each of its values makes sense, even if it is not the one that the index states.
    ///
    /// # Errors
    /// Returns an error if there is no such world in the index.
    pub fn examine_world(&self, id: &str) -> Result<(Option<World>, Vec<SuiteError>), SuiteError> {
        let info = self.world_info(id)?;
        let folder = world_folder(&self.dir, id);
        let read = WorldFiles::read(&folder).and_then(|files| Ok((files.parse(&folder)?, files.hash())));
        let (world, hash) = match read {
            Ok(read) => read,
            Err(e) => return Ok((None, vec![e])),
        };
        let flaws = world.flaws();
        if !flaws.is_empty() {
            return Ok((None, flaws.into_iter().map(|f| SuiteError::flaw(&folder, f)).collect()));
        }
        let errors = self.agrees(info, &world, hash).err().into_iter().collect();
        Ok((Some(world), errors))
    }

    /// Whether a world of this hash is the one that the index states.
    fn agrees(&self, info: &WorldInfo, world: &World, found: String) -> Result<(), SuiteError> {
        let file = self.dir.join(INDEX);
        if found != info.sha256 {
            return Err(SuiteError::Hash {
                file,
                world: info.id.clone(),
                stated: info.sha256.clone(),
                found,
            });
        }
        let stored = info_of(world, found);
        if stored == *info {
            return Ok(());
        }
        let k = self.worlds.iter().position(|w| w.id == info.id).unwrap_or(0);
        let problem =
            format!("says {}, but the world's files say {}: make them agree", brief(info), brief(&stored));
        Err(SuiteError::invalid(&file, format!("worlds[{k}]"), problem))
    }

    /// Checks by their hash that a world's files are those of the index, which is much faster than to read it.
    ///
    /// # Errors
    /// Returns the error of [`Suite::load_world`], which is asked what is wrong if the hashes differ.
    pub fn verify_world(&self, id: &str) -> Result<(), SuiteError> {
        let info = self.world_info(id)?;
        let files = WorldFiles::read(&world_folder(&self.dir, id))?;
        if files.hash() == info.sha256 { Ok(()) } else { self.load_world(id).map(drop) }
    }

    /// The content hash of the suite: the SHA-256, in hexadecimal, over the schema version and over the ids and content
    /// hashes of all worlds in order. It depends on neither path nor system, name nor description.
    #[must_use]
    pub fn hash(&self) -> String {
        let mut hasher = Hash::new();
        hasher.update(format!("verti-bench suite, schema {SCHEMA}\n"));
        for w in &self.worlds {
            hasher.update(format!("{} {}\n", w.id, w.sha256));
        }
        hasher.hex()
    }
}

/// A writer of a suite, world by world, with the index last: an interrupted writer leaves no suite that looks whole.
#[derive(Debug)]
pub struct SuiteWriter {
    suite: Suite,
}

impl SuiteWriter {
    /// Prepares `dir`, which must not exist or be empty.
    ///
    /// # Errors
    /// Returns an error if the directory holds something or cannot be made.
    pub fn create(dir: impl AsRef<Path>, meta: SuiteMeta) -> Result<Self, SuiteError> {
        let dir = dir.as_ref().to_path_buf();
        std::fs::create_dir_all(&dir).map_err(|e| SuiteError::write(&dir, e))?;
        let mut entries = std::fs::read_dir(&dir).map_err(|e| SuiteError::write(&dir, e))?;
        if entries.next().is_some() {
            return Err(SuiteError::NotEmpty { path: dir });
        }
        Ok(Self { suite: Suite { dir, meta, worlds: Vec::new() } })
    }

    /// Adds a world to the suite.
    ///
    /// # Errors
    /// Returns an error if the world has a flaw, its id is taken, or it cannot be written.
    pub fn add(&mut self, world: &World) -> Result<&WorldInfo, SuiteError> {
        let folder = world_folder(&self.suite.dir, &world.id);
        let files = WorldFiles::from_world(world).map_err(|f| SuiteError::flaw(&folder, f))?;
        let worlds = &mut self.suite.worlds;
        worlds.push(info_of(world, files.hash()));
        check_index(worlds)
            .map_err(|(field, problem)| SuiteError::invalid(&self.suite.dir.join(INDEX), field, problem))?;
        files.write(&folder)?;
        Ok(&worlds[worlds.len() - 1])
    }

    /// Writes the index and opens the suite.
    ///
    /// # Errors
    /// Returns an error if the index cannot be written.
    pub fn finish(self) -> Result<Suite, SuiteError> {
        let file = self.suite.dir.join(INDEX);
        std::fs::write(&file, index(&self.suite)).map_err(|e| SuiteError::write(&file, e))?;
        Ok(self.suite)
    }
}

fn world_folder(dir: &Path, id: &str) -> PathBuf {
    dir.join("worlds").join(id)
}

fn info_of(world: &World, sha256: String) -> WorldInfo {
    WorldInfo {
        id: world.id.clone(),
        elevation: world.elevation,
        terrain: world.terrain,
        density: world.density,
        tasks: world.tasks.iter().map(|t| t.id.clone()).collect(),
        sha256,
    }
}

fn brief(w: &WorldInfo) -> String {
    let (elevation, terrain, density) = (w.elevation.name(), w.terrain.name(), w.density.name());
    format!("{} ({elevation}, {terrain}, {density}, tasks [{}])", w.id, w.tasks.join(", "))
}

fn check_index(worlds: &[WorldInfo]) -> Result<(), (String, String)> {
    let mut ids = BTreeSet::new();
    for (k, w) in worlds.iter().enumerate() {
        let flaw = |field: &str, problem| Err((format!("worlds[{k}].{field}"), problem));
        if let Err(problem) = check_id(&w.id) {
            return flaw("id", problem);
        }
        if !ids.insert(&w.id) {
            return flaw("id", format!("{:?} is used twice: give each world its own", w.id));
        }
        if w.sha256.len() != 64 || !w.sha256.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f')) {
            return flaw(
                "sha256",
                format!("{:?} is not a SHA-256 of 64 hexadecimal digits in lower case", w.sha256),
            );
        }
    }
    Ok(())
}

/// The text of `suite.yaml`.
fn index(suite: &Suite) -> String {
    let SuiteMeta { name, version, description, provenance } = &suite.meta;
    let provenance = match provenance {
        Provenance::Generated { generator, seed } => {
            format!("generated: {{generator: {}, seed: {seed}}}", text::quoted(generator))
        }
        Provenance::Imported { source, place: None } => {
            format!("imported: {{source: {}}}", text::quoted(source))
        }
        Provenance::Imported { source, place: Some(place) } => {
            let Georeference { crs, proj, metres: [x, y], origins } = place;
            let proj =
                proj.as_ref().map_or_else(String::new, |p| format!("\n      proj: {}", text::quoted(p)));
            let origins: String = origins
                .iter()
                .map(|(world, [x, y])| format!("\n        {}: [{x:?}, {y:?}]", text::quoted(world)))
                .collect();
            let origins = if origins.is_empty() { " {}".to_owned() } else { origins };
            let crs = text::quoted(crs);
            format!(
                "imported:\n    source: {}\n    place:\n      crs: {crs}{proj}\n      metres: [{x:?}, {y:?}]\n      origins:{origins}",
                text::quoted(source)
            )
        }
        Provenance::Authored { by } => format!("authored: {{by: {}}}", text::quoted(by)),
    };
    let [name, version, description] = [name, version, description].map(|s| text::quoted(s));
    let mut out = format!(
        "schema: {SCHEMA}\nname: {name}\nversion: {version}\ndescription: {description}\nprovenance:\n  {provenance}\n"
    );
    out.push_str(if suite.worlds.is_empty() { "worlds: []\n" } else { "worlds:\n" });
    for w in &suite.worlds {
        let (elevation, terrain, density) = (w.elevation.name(), w.terrain.name(), w.density.name());
        let _ = write!(
            out,
            "  - id: {}\n    elevation: {elevation}\n    terrain: {terrain}\n    density: {density}\n    \
             tasks: [{}]\n    sha256: {}\n",
            w.id,
            w.tasks.join(", "),
            text::quoted(&w.sha256),
        );
    }
    out
}
