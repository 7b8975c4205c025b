//! What comes with the harness, found by its name: suites, vehicles, soils, perception profiles, and the training worlds
//! that the generator draws. Whatever may be named may also be a file or a folder of the user's.

mod carried;
mod error;
mod places;
mod training;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use vb_sense::Profile;
use vb_sim::{SoilSet, Soils};
use vb_vehicle::{Vehicle, VehicleSpec};
use vb_world::{Selector, SelectorError, Suite, TaskId, WorldInfo};

pub use carried::Carried;
pub use error::CatalogError;
pub use places::{
    CACHE_VAR, DATA_VAR, PLUGINS_VAR, TASKS_VAR, cache_dir, data_dir, installed_planners, planner_dirs,
};

/// The suite that is run where none is named.
pub const DEFAULT_SUITE: &str = "vb-100";

/// A kind of data file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Data {
    /// `tasks/vehicles`.
    Vehicle,
    /// `tasks/soils`.
    Soils,
    /// `tasks/perception`.
    Perception,
}

impl Data {
    fn folder(self) -> &'static str {
        match self {
            Self::Vehicle => "vehicles",
            Self::Soils => "soils",
            Self::Perception => "perception",
        }
    }

    /// What one file is called in messages.
    #[must_use]
    pub fn noun(self) -> &'static str {
        match self {
            Self::Vehicle => "vehicle",
            Self::Soils => "soil set",
            Self::Perception => "perception profile",
        }
    }
}

/// The folder `tasks` that comes with the harness.
#[derive(Clone, Debug)]
pub struct Catalog {
    tasks: OnceLock<PathBuf>,
    /// What is unpacked where there is no folder.
    carried: Option<Carried>,
    cache: Option<PathBuf>,
}

impl Catalog {
    /// The folder that the environment variable [`TASKS_VAR`] names, else one in a directory above the program, else one in or
    /// above the working directory. Where there is none, only files and folders of the user's are found.
    #[must_use]
    pub fn find() -> Self {
        places::tasks()
            .map_or_else(|| Self { tasks: OnceLock::new(), carried: None, cache: cache_dir() }, Self::at)
    }

    /// The same, with what the program carries within itself where no folder is found. It is unpacked when it is first needed.
    #[must_use]
    pub fn or(self, carried: Carried) -> Self {
        Self { carried: Some(carried), ..self }
    }

    #[must_use]
    pub fn at(tasks: impl Into<PathBuf>) -> Self {
        Self { tasks: OnceLock::from(tasks.into()), carried: None, cache: cache_dir() }
    }

    /// The same, with training worlds kept in this folder instead of [`cache_dir`].
    #[must_use]
    pub fn keeping_in(self, cache: impl Into<PathBuf>) -> Self {
        Self { cache: Some(cache.into()), ..self }
    }

    /// The folder.
    ///
    /// # Errors
    /// Returns [`CatalogError::NoTasks`] if there is none, and an error if it can't be unpacked.
    pub fn tasks(&self) -> Result<&Path, CatalogError> {
        if let Some(tasks) = self.tasks.get() {
            return Ok(tasks);
        }
        let unpacked = self.carried.ok_or(CatalogError::NoTasks)?.unpacked()?;
        Ok(self.tasks.get_or_init(|| unpacked))
    }

    /// The built-in suites, by name.
    pub fn suites(&self) -> Result<Vec<PathBuf>, CatalogError> {
        let dir = self.tasks()?;
        let entries =
            std::fs::read_dir(dir).map_err(|source| CatalogError::List { path: dir.to_owned(), source })?;
        let mut found: Vec<PathBuf> =
            entries.flatten().map(|e| e.path()).filter(|p| p.join("suite.yaml").is_file()).collect();
        found.sort();
        Ok(found)
    }

    /// The suite that the user means: the name of one that comes with the harness, or a directory; vb-100 if none is named. A
    /// directory that is called as one that comes with the harness is meant by a path, such as `./smoke`.
    ///
    /// # Errors
    /// Returns an error if there is no suite of this name.
    pub fn suite(&self, wanted: Option<&Path>) -> Result<PathBuf, CatalogError> {
        let Some(wanted) = wanted else {
            return Ok(self.tasks()?.join(DEFAULT_SUITE));
        };
        let Some(name) = wanted.to_str().filter(|_| is_name(wanted.as_os_str())) else {
            return Ok(wanted.to_owned());
        };
        match self.own_suite(name) {
            Err(_) if wanted.exists() => Ok(wanted.to_owned()),
            found => found,
        }
    }

    /// The suite of this name that comes with the harness, whatever lies in the working directory.
    ///
    /// # Errors
    /// Returns an error if there is none.
    pub fn own_suite(&self, name: &str) -> Result<PathBuf, CatalogError> {
        let all = self.suites()?;
        if let Some(found) = all.iter().find(|p| p.file_name() == Some(OsStr::new(name))) {
            return Ok(found.clone());
        }
        let names: Vec<_> = all.iter().filter_map(|p| p.file_name()).map(OsStr::to_string_lossy).collect();
        if names.is_empty() {
            return Err(self.nothing("suite"));
        }
        Err(CatalogError::Unknown {
            noun: "suite",
            name: name.to_owned(),
            instead: "a directory",
            known: names.join(", "),
        })
    }

    /// Opens the suite that the user means.
    ///
    /// # Errors
    /// Returns an error if there is no suite of this name, or it can't be read.
    pub fn open_suite(&self, wanted: Option<&Path>) -> Result<Suite, CatalogError> {
        Ok(Suite::open(self.suite(wanted)?)?)
    }

    /// The terrain model of this name that comes with the harness.
    ///
    /// # Errors
    /// Returns an error if the folder is missing.
    pub fn terrain_model(&self, name: &str) -> Result<PathBuf, CatalogError> {
        Ok(self.tasks()?.join("terrain").join(format!("{name}.safetensors")))
    }

    /// The data file that the user means: a path, or the name of one that comes with the harness.
    ///
    /// # Errors
    /// Returns an error if there is none of this name.
    pub fn data(&self, kind: Data, wanted: &str) -> Result<PathBuf, CatalogError> {
        if !is_name(OsStr::new(wanted)) || Path::new(wanted).is_file() {
            return Ok(PathBuf::from(wanted));
        }
        self.own_data(kind, wanted)
    }

    /// The data file of this name that comes with the harness, whatever lies in the working directory.
    ///
    /// # Errors
    /// Returns an error if there is none.
    pub fn own_data(&self, kind: Data, wanted: &str) -> Result<PathBuf, CatalogError> {
        let file = self.tasks()?.join(kind.folder()).join(format!("{wanted}.yaml"));
        if file.is_file() {
            return Ok(file);
        }
        let known = self.names(kind)?;
        if known.is_empty() {
            return Err(self.nothing(kind.noun()));
        }
        Err(CatalogError::Unknown {
            noun: kind.noun(),
            name: wanted.to_owned(),
            instead: "a file",
            known: known.join(", "),
        })
    }

    /// The error that the folder has nothing of a kind, such as a suite.
    #[must_use]
    pub fn nothing(&self, noun: &'static str) -> CatalogError {
        match self.tasks() {
            Ok(tasks) => CatalogError::Nothing { noun, tasks: tasks.to_owned() },
            Err(e) => e,
        }
    }

    /// The names of the data files of a kind that come with the harness.
    pub fn names(&self, kind: Data) -> Result<Vec<String>, CatalogError> {
        let dir = self.tasks()?.join(kind.folder());
        let mut names: Vec<String> = std::fs::read_dir(&dir)
            .into_iter()
            .flatten()
            .flatten()
            .filter_map(|e| e.file_name().to_string_lossy().strip_suffix(".yaml").map(str::to_owned))
            .collect();
        names.sort();
        Ok(names)
    }

    /// The file of reference figures that comes with the harness for a vehicle of this name, if there is one.
    #[must_use]
    pub fn references(&self, vehicle: &str) -> Option<PathBuf> {
        let file = self.tasks().ok()?.join("validation").join(format!("{vehicle}.yaml"));
        file.is_file().then_some(file)
    }

    /// A vehicle by its name or file.
    ///
    /// # Errors
    /// Returns an error if there is none of this name, or its file can't be used.
    pub fn vehicle(&self, wanted: &str) -> Result<Vehicle, CatalogError> {
        vehicle_of(&self.data(Data::Vehicle, wanted)?)
    }

    /// A set of soils by its name or file, and the side of the cells in which soil remembers ruts, m.
    ///
    /// # Errors
    /// Returns an error if there is none of this name, or its file can't be used.
    pub fn soils(&self, wanted: &str, resolution: f64) -> Result<Soils, CatalogError> {
        soils_of(&self.data(Data::Soils, wanted)?, resolution)
    }

    /// A perception profile by its name or file.
    ///
    /// # Errors
    /// Returns an error if there is none of this name, or its file can't be used.
    pub fn perception(&self, wanted: &str) -> Result<Profile, CatalogError> {
        perception_at(self.data(Data::Perception, wanted), wanted)
    }

    /// The perception profile of this name that comes with the harness, whatever lies in the working directory.
    ///
    /// # Errors
    /// Returns an error if there is none of this name, or its file can't be used.
    pub fn own_perception(&self, wanted: &str) -> Result<Profile, CatalogError> {
        perception_at(self.own_data(Data::Perception, wanted), wanted)
    }
}

/// The vehicle in this file.
///
/// # Errors
/// Returns an error if the file can't be used.
pub fn vehicle_of(path: &Path) -> Result<Vehicle, CatalogError> {
    let (file, text, hash) = read_data(Data::Vehicle, path)?;
    Ok(Vehicle { spec: VehicleSpec::parse(&text, &file)?, hash })
}

/// The set of soils in this file, and the side of the cells in which soil remembers ruts, m.
///
/// # Errors
/// Returns an error if the file can't be used.
pub fn soils_of(path: &Path, resolution: f64) -> Result<Soils, CatalogError> {
    let (file, text, hash) = read_data(Data::Soils, path)?;
    Ok(Soils { set: SoilSet::parse(&text, &file)?, hash, resolution })
}

/// The profile in a file, or the one that is built in where the folder of tasks lacks it, as it does in a folder with suites
/// alone.
fn perception_at(file: Result<PathBuf, CatalogError>, wanted: &str) -> Result<Profile, CatalogError> {
    match (file, Profile::built_in(wanted)) {
        (Ok(path), _) => Ok(Profile::load(&path)?),
        (Err(_), Some(profile)) => Ok(profile),
        (Err(error), None) => Err(error),
    }
}

/// The tasks that a selector chooses, in the suite's order; without one, all.
///
/// # Errors
/// Returns an error if the selector makes no sense, or names what the suite doesn't have.
pub fn select(suite: &Suite, selector: Option<&str>) -> Result<Vec<TaskId>, SelectorError> {
    let Some(text) = selector else {
        return Ok(suite.worlds().iter().flat_map(WorldInfo::task_ids).collect());
    };
    Selector::parse(text)?.select(suite)
}

/// (path, text, SHA-256 in hexadecimal) of a data file.
fn read_data(kind: Data, path: &Path) -> Result<(String, String, String), CatalogError> {
    let text = vb_files::read_text(path, vb_files::DOCUMENT).map_err(|source| CatalogError::Read {
        noun: kind.noun(),
        path: path.to_owned(),
        source,
    })?;
    let hash = vb_files::sha256(text.as_bytes());
    Ok((path.display().to_string(), text, hash))
}

/// Whether this is a bare name rather than a path.
#[must_use]
pub fn is_name(text: &OsStr) -> bool {
    !text.to_string_lossy().contains(['/', '\\', '.'])
}
