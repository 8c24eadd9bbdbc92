//! The program run as a process: exit codes, messages, files, signals.

mod claims;
mod comparisons;
mod ensembles;
mod failing_runs;
mod invalid_scenes;
mod other_commands;
mod parts;
mod plugins;
mod runs;
mod support;
