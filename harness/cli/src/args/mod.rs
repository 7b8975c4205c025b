//! Arguments that several commands share.

mod common;
pub(crate) mod exit_codes;
pub(crate) mod values;

pub(crate) use common::{
    ForceArgs, FormatArgs, GlobalArgs, JobsArgs, MessageFormat, PERCEPTION, PlannerArgs, PluginArgs, RULES,
    ReplayData, ResumeArgs, SOIL_RESOLUTION, SOILS, TIME_STEP, VEHICLE,
};
