//! One module for each command.

pub mod check;
pub mod compare;
pub mod describe;
pub mod ensemble;
pub mod evaluate;
pub mod explain;
pub mod explain_word;
pub mod find;
pub mod import;
pub mod learn;
pub mod list;
pub mod merge;
mod motion;
pub mod new;
pub mod plugin;
pub mod reproduce;
pub mod run;
pub mod schema;
pub mod shadow;
mod shard;
pub mod stress;
pub mod sweep;
pub mod tabulate;
pub mod tune;
pub mod verify;
