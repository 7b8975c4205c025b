//! Vehicle dynamics: suspension, tyres, powertrain, contacts.
