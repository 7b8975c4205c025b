//! A wheel on its own, for tests of the tyres.
