//! PID
