//! proofmass rig.
