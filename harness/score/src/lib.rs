//! Rules, outcomes, metrics and summaries.
