//! Evaluates predictions by errors, associativity, regions, retrieval, warnings, and real shapes,
//! in comparison with baselines.

mod baselines;
mod body_cuts;
mod clouds;
mod held_out;
mod metrics;
mod oracle;
mod real;
mod regions;
mod retrieval;
mod study;
mod warning;

pub use baselines::{Minimum, Nearest, Perceptron, Weyl};
pub use body_cuts::{
    BODY_CUTS, BodyCut, Frame, body_pairs, body_parts, mirrored_union, part_pairs,
};
pub use clouds::{CloudError, body_clouds};
pub use held_out::{Bodies, held_out};
pub use metrics::{Associativity, Errors, Predictor, associativity, errors, select};
pub use oracle::{Disturbance, ErrorModel, Logs, errors_by_index};
pub use real::{REAL_SHAPES, RealShape};
pub use regions::{Localization, localization};
pub use retrieval::{Gallery, Query, Retrieval};
pub use study::{RetrievalStudy, Source};
pub use warning::{DOCUMENTED_THRESHOLD, Detection, Judgement, THRESHOLDS, WRONG};
