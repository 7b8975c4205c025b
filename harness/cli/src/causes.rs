//! The exit code of each error of the libraries. Every variant is named, so that a new one is put where it belongs.

use vb_catalog::CatalogError;
#[cfg(feature = "dataset")]
use vb_dataset::DatasetError;
use vb_host::LoadError;
use vb_record::StoreError;
#[cfg(feature = "replay")]
use vb_replay::film::FilmError;
use vb_report::ReportError;
use vb_runner::conformance::KitError;
use vb_runner::{MergeError, RunError};
use vb_score::RescoreError;
use vb_submission::SubmissionError;
use vb_suite::generate::GenerateError;
use vb_suite::proof::ProofError;
use vb_trial::TrialError;
#[cfg(feature = "vehicle")]
use vb_validate::ValidateError;
use vb_world::SuiteError;

use crate::error::CliError;
use crate::planner;

impl From<StoreError> for CliError {
    fn from(e: StoreError) -> Self {
        match &e {
            StoreError::Encode { .. } => Self::internal(e),
            StoreError::NotEmpty(_)
            | StoreError::Taken(_)
            | StoreError::Locked(_)
            | StoreError::Differs { .. } => Self::output(e),
            StoreError::Io { .. } if e.is_of_output() => Self::output(e),
            // A run that can't be read is the same, whatever was to be done with it.
            StoreError::Io { .. }
            | StoreError::NoRun(_)
            | StoreError::Schema { .. }
            | StoreError::Damaged { .. } => Self::input(e),
        }
    }
}

impl From<SuiteError> for CliError {
    fn from(e: SuiteError) -> Self {
        match e {
            SuiteError::Write { .. } | SuiteError::NotEmpty { .. } => Self::output(e),
            SuiteError::Read { .. }
            | SuiteError::Invalid { .. }
            | SuiteError::Schema { .. }
            | SuiteError::Hash { .. }
            | SuiteError::UnknownWorld { .. } => Self::input(e),
        }
    }
}

impl From<GenerateError> for CliError {
    fn from(e: GenerateError) -> Self {
        match e {
            GenerateError::Suite(e) => e.into(),
            GenerateError::Surface { .. }
            | GenerateError::NoStart { .. }
            | GenerateError::NoPatch { .. }
            | GenerateError::NoRoom { .. }
            | GenerateError::NoWay { .. }
            | GenerateError::World { .. }
            | GenerateError::Rules(_) => Self::input(e),
        }
    }
}

impl From<CatalogError> for CliError {
    fn from(e: CatalogError) -> Self {
        match e {
            CatalogError::KeptForTraining(_) => Self::usage(e),
            // The option's name is the command line's.
            CatalogError::NoTrainingSeed(_) => Self::usage(format!("--{e}")),
            CatalogError::Write { .. } | CatalogError::NoDataFolder | CatalogError::Unpack { .. } => {
                Self::output(e)
            }
            CatalogError::Suite(e) => e.into(),
            CatalogError::Generate(e) => e.into(),
            CatalogError::NoTasks
            | CatalogError::Nothing { .. }
            | CatalogError::Unknown { .. }
            | CatalogError::List { .. }
            | CatalogError::Read { .. }
            | CatalogError::Document(_)
            | CatalogError::Terrain(_) => Self::input(e),
        }
    }
}

impl From<TrialError> for CliError {
    fn from(e: TrialError) -> Self {
        match e {
            TrialError::Scale(_) => Self::usage(e),
            TrialError::Vehicle(_) | TrialError::Simulation(_) | TrialError::Perception { .. } => {
                Self::input(e)
            }
        }
    }
}

impl From<RunError> for CliError {
    fn from(e: RunError) -> Self {
        match e {
            RunError::Store(e) => e.into(),
            RunError::Suite(e) => e.into(),
            RunError::Trial(e) => e.into(),
            RunError::Param(_) | RunError::NoTasks => Self::usage(e),
            RunError::Thread(_) => Self::host_errors(e),
            RunError::ControlPeriod { .. } | RunError::ForeignTask { .. } | RunError::Recorded { .. } => {
                Self::input(e)
            }
        }
    }
}

impl From<MergeError> for CliError {
    fn from(e: MergeError) -> Self {
        match e {
            MergeError::Store(e) => e.into(),
            MergeError::Nothing(_)
            | MergeError::NoShard(_)
            | MergeError::Mixed { .. }
            | MergeError::OtherSuite { .. }
            | MergeError::Selector(_)
            | MergeError::Rules { .. }
            | MergeError::Conflict { .. }
            | MergeError::Foreign { .. } => Self::input(e),
        }
    }
}

impl From<KitError> for CliError {
    fn from(e: KitError) -> Self {
        match e {
            KitError::Load(LoadError::Faulty { .. }) | KitError::Host(_) => Self::host_errors(e),
            KitError::Load(e) => planner::unusable(&e),
            KitError::Param(_) => Self::usage(e),
            KitError::Run(e) => e.into(),
            KitError::Cancelled => Self::interrupted(e),
        }
    }
}

#[cfg(feature = "dataset")]
impl From<DatasetError> for CliError {
    fn from(e: DatasetError) -> Self {
        match e {
            DatasetError::Io { action: "read", .. } => Self::input(e),
            DatasetError::Io { .. }
            | DatasetError::NotEmpty { .. }
            | DatasetError::Within { .. }
            | DatasetError::Other { .. } => Self::output(e),
            DatasetError::Record(e) => e.into(),
            DatasetError::Suite(e) => e.into(),
            DatasetError::Trial(e) => e.into(),
            DatasetError::Rate { .. } | DatasetError::Parts { .. } => Self::usage(e),
            DatasetError::Encode { .. } => Self::internal(e),
            DatasetError::Thread(_) => Self::host_errors(e),
            DatasetError::Damaged { .. }
            | DatasetError::Changed { .. }
            | DatasetError::Foreign { .. }
            | DatasetError::Missing { .. }
            | DatasetError::Schema { .. }
            | DatasetError::Unfinished { .. }
            | DatasetError::SuiteWorld { .. }
            | DatasetError::Planner { .. }
            | DatasetError::NoStart { .. }
            | DatasetError::NotRepeated { .. }
            | DatasetError::Empty(_)
            | DatasetError::Unlike { .. }
            | DatasetError::Repeated { .. } => Self::input(e),
        }
    }
}

impl From<ReportError> for CliError {
    fn from(e: ReportError) -> Self {
        match e {
            ReportError::Store(e) => e.into(),
            ReportError::Write { .. } => Self::output(e),
            ReportError::Twice(_)
            | ReportError::NoRuns
            | ReportError::Label { .. }
            | ReportError::LabelTaken { .. } => Self::usage(e),
            ReportError::Empty(_) | ReportError::Suites { .. } => Self::input(e),
        }
    }
}

impl From<RescoreError> for CliError {
    fn from(e: RescoreError) -> Self {
        match e {
            RescoreError::Store(e) => e.into(),
            RescoreError::NoTraces(_) => Self::input(e),
        }
    }
}

impl From<SubmissionError> for CliError {
    fn from(e: SubmissionError) -> Self {
        match e {
            SubmissionError::Write { .. } | SubmissionError::NotEmpty(_) => Self::output(e),
            SubmissionError::Entrant { .. } | SubmissionError::Replay { .. } => Self::usage(e),
            SubmissionError::Machine { .. } => Self::host_errors(e),
            SubmissionError::Interrupted => Self::interrupted(e),
            SubmissionError::Run(e) => e.into(),
            SubmissionError::Store(e) => e.into(),
            SubmissionError::Report(e) => e.into(),
            SubmissionError::Read { .. }
            | SubmissionError::Shard { .. }
            | SubmissionError::TooLarge { .. }
            | SubmissionError::Unsafe { .. }
            | SubmissionError::NoSubmission(_)
            | SubmissionError::Schema { .. }
            | SubmissionError::Damaged { .. }
            | SubmissionError::Version { .. }
            | SubmissionError::Unfinished { .. }
            | SubmissionError::Other { .. }
            | SubmissionError::NoFile
            | SubmissionError::Entry { .. }
            | SubmissionError::Plugin(_) => Self::input(e),
        }
    }
}

#[cfg(feature = "replay")]
impl From<FilmError> for CliError {
    fn from(e: FilmError) -> Self {
        match e {
            FilmError::Encoder { .. } | FilmError::Write { .. } => Self::output(e),
            FilmError::Run { .. } | FilmError::Picture { .. } | FilmError::Caption(_) => Self::input(e),
            FilmError::Runs { .. }
            | FilmError::Small { .. }
            | FilmError::Time { .. }
            | FilmError::Backwards { .. }
            | FilmError::Rate { .. }
            | FilmError::Long { .. }
            | FilmError::Format { .. }
            | FilmError::Odd { .. }
            | FilmError::NoEncoder { .. } => Self::usage(e),
        }
    }
}

#[cfg(feature = "vehicle")]
impl From<ValidateError> for CliError {
    fn from(e: ValidateError) -> Self {
        match e {
            ValidateError::UnknownEvent { .. }
            | ValidateError::NotForVehicle { .. }
            | ValidateError::Step { .. } => Self::usage(e),
            ValidateError::Write { .. } => Self::output(e),
            ValidateError::Document(_) | ValidateError::Simulation(_) => Self::input(e),
        }
    }
}

/// An error of writing a certificate. One that can't be read is input: see [`ProofError`].
impl From<ProofError> for CliError {
    fn from(e: ProofError) -> Self {
        match e {
            ProofError::File { .. } => Self::output(e),
            ProofError::Damaged { .. } | ProofError::OtherSuite { .. } => Self::input(e),
        }
    }
}
