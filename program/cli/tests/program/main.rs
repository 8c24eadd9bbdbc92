//! The program run as a process: exit codes, messages, files, signals.

mod bits;
mod claims;
mod comparisons;
mod ensembles;
mod events;
mod failing_runs;
mod gallery;
mod guide;
mod invalid_scenes;
mod kills;
mod motion;
mod noise;
mod other_commands;
mod paces;
mod parts;
mod plugins;
mod runs;
mod sections;
mod shadow;
mod shards;
mod sites;
mod states;
mod support;
mod sweeps;
mod time;
mod warnings;
