//! What the arguments of several commands have in common.

mod common;
pub(crate) mod exit_codes;
pub(crate) mod values;

pub(crate) use common::{
    ForceArgs, FormatArgs, GlobalArgs, JobsArgs, MessageFormat, PERCEPTION, PlannerArgs, PluginArgs, RULES,
    ReplayData, ResumeArgs, SOIL_RESOLUTION, SOILS, TIME_STEP, VEHICLE,
};
