//! proofmass motion.
