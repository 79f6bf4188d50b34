//! The host side of Skyfront.
