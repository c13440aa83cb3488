//! Plants: the water in them against closed forms and a double-double reference, and the rods
//! against beam theory.

mod reference;

mod accuracy;
mod damage;
mod drought;
mod files;
mod fit;
mod leaves;
mod models;
mod motion;
mod rods;
mod storm;
