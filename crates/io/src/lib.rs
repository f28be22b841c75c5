//! proofmass io.
