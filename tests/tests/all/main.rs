//! What spans the crates, as one program: thirty would each be linked with cfitsio. A part alone is
//! `cargo test -p skyfront-tests PART::`.

mod agreement;
mod budget;
mod catalogue;
mod chan_vese;
mod cli;
mod convergence;
mod crosscheck;
mod detection;
mod facts;
mod facts_image;
mod faults;
mod fd_filtered;
mod fixed_point;
mod habits;
mod labels;
mod maps;
mod measures;
mod memory;
mod no_panic;
mod paper_table;
mod pipeline;
mod reading;
mod reference_facts;
mod report;
mod scores;
mod sky;
mod snapshots;
mod sources;
mod speed;
mod symmetry;
mod thresholds;
mod upsets;
mod wrappings;
mod zoo;
