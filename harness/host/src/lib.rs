//! Loads planner plugins (WASM components and native libraries) and drives them within limits.
