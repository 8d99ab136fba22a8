//! The numbers by which a diagnosis decides, in one place, each with what set it.
//!
//! *Chosen*: by the argument that is given, not from data. *Campaign*: set while the synthetic sets
//! of the test laboratory were diagnosed, with other seeds than those of docs/diagnosis.md.
//! *`MuJoCo`*: set while jumps of an independent simulator were diagnosed, with and without a
//! hidden effect. *Real data*: set on the measurements of docs/diagnosis.md. The history of the
//! repository tells the sort of data only, not the sets. Constants of numerical methods (steps of a
//! fit, of a difference quotient) stand beside the methods.

/// The numbers by which a diagnosis decides. σ is the standard deviation of a reading; a loss is
/// twice a negative log-likelihood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Policy {
    // Noise.
    /// Residuals beyond so many σ count in proportion to their size (Huber). Chosen: normal noise
    /// has 0.3 % of them.
    pub huber: f64,
    /// A robust standard deviation up to so many times the stated one is taken as the stated one.
    /// Real data, whose instruments drift.
    pub noise_as_stated: f64,
    /// Variance inflation above which residuals count as correlated: runs are then compared, not
    /// readings. Real data.
    pub correlated_inflation: f64,
    /// A stated noise so many times the observed one is not used. Chosen: a filter of the
    /// instrument and the wish to be on the safe side explain a smaller factor.
    pub noise_disbelieved: f64,
    /// Least noise of a column, as a part of its range. Chosen: models of machines are not better.
    pub finest_noise: f64,
    /// Equal readings of a quantised column, one after the other, count as this many. Campaign.
    pub repeated_readings: f64,
    /// Noise, in steps of a quantised column, above which each reading has a rounding error of
    /// its own. Campaign.
    pub dither: f64,

    // Screen and add.
    /// Part of the false-alarm rate that goes to effects without a name. Chosen.
    pub unknown_share: f64,
    /// Probability below which the χ² of one more cause counts as chance. Chosen: 0.1 %.
    pub chance_quantile: f64,
    /// Gain in the score test below which no fit is made. Chosen: 2 σ of one parameter. This and
    /// the next five save fits; the score test itself does not depend on them.
    pub least_score: f64,
    /// Robust standard deviation of the residuals of a channel (σ) above which all causes are
    /// fitted, as scores rest on slopes. Real data: of a pendulum without friction that is driven.
    pub far_off: f64,
    /// So many causes with the greatest scores are fitted. Chosen.
    pub most_fitted: usize,
    /// Part of the best score that a cause of these must reach. Chosen.
    pub score_of_few: f64,
    /// The same beside others where more than `many_causes` may be at work. Chosen, to save time.
    pub score_of_few_of_many: f64,
    /// See `score_of_few_of_many`.
    pub many_causes: usize,
    /// Part of the best score from which on a cause is fitted whatever its rank. Chosen.
    pub score_of_any: f64,
    /// The same of a cause that cannot be reached in small steps, where the score is rough. Chosen.
    pub score_of_apart: f64,
    /// Part of the threshold that some score must reach for another cause to be sought. Chosen: a
    /// score may be half of the gain of the fit.
    pub score_of_threshold: f64,
    /// Part of the best gain below which the fit of a cause with many starts is given up. Chosen,
    /// to save time.
    pub gain_of_far: f64,
    /// Part of the best gain from which on a cause at a bound makes the search start again over
    /// whole ranges. Campaign: a slide that dry friction holds, 199 and 200 N.
    pub gain_at_bound: f64,
    /// Candidates that are compared on data left out. Chosen.
    pub most_compared: usize,
    /// Part of the first candidate's gain by which these may be behind (`rival_loss` at least).
    /// Chosen.
    pub behind_part: f64,
    /// The same where residuals are correlated, and a gain tells less. Real data.
    pub behind_part_correlated: f64,
    /// Where residuals are correlated, the part of the misfit that each cause must explain. Real
    /// data.
    pub share_correlated: f64,
    /// Part of the loss on data left out below which a model with one more cause shows, run by run,
    /// that what the one before it leaves is no chance. Real data: of a pendulum that is driven.
    pub far_better: f64,
    /// Where residuals are correlated, the least part of the loss on data left out that one more cause
    /// must take. Real data.
    pub least_part_held_out: f64,
    /// Readings of a channel over which an effect must last to count as one. `MuJoCo`: an event
    /// that comes one row later changes one reading.
    pub lasting_readings: usize,

    // Pairs and exchange.
    /// Loss that two causes must explain together where neither does alone. Chosen: far beyond what
    /// the best of some hundred pairs explains by chance.
    pub pair_gain: f64,
    /// Part of the misfit that they must explain. Campaign: two effects at once.
    pub pair_part: f64,
    /// Pairs that are fitted in this search. Chosen.
    pub pairs_fitted: usize,
    /// Pairs that are fitted to replace causes found one by one. Chosen.
    pub pairs_compared: usize,

    // Rivals.
    /// Difference in loss below which data do not tell two causes apart: a likelihood ratio of 7
    /// to 1. Chosen.
    pub rival_loss: f64,
    /// Rivals that are named with a cause; the others are less likely. Chosen: an
    /// answer with more names is no answer.
    pub most_rivals: usize,
    /// Part of the best gain above which losses of left-out data decide about a rival, where
    /// residuals are correlated. Real data.
    pub rival_part_correlated: f64,
    /// Gains that differ by less than this part (and half a unit) are equal. Chosen.
    pub equal_gain: f64,
    /// Standard deviations from what is known beyond which a cause contradicts it. Chosen: once in
    /// two million times by chance.
    pub contradiction: f64,
    /// A parameter is unlimited if its bound is farther than so many times the least that explains
    /// the data. Chosen.
    pub unlimited: f64,
    /// σ of a reading by which two predictions are told apart for sure. Chosen.
    pub told_apart: f64,

    // Unknown.
    /// Part of the misfit that may remain because the true law differs slightly in shape from the
    /// modelled one. Real data.
    pub form_error: f64,
    /// The same of a single run, where it cannot be seen what repeats. Chosen.
    pub form_error_of_one_run: f64,
    /// Part of the misfit that causes must explain where something is left beside them. Chosen.
    pub explained: f64,
    /// Mean square of residuals beyond 1, or of their smooth part (σ²), below which nothing is
    /// reported as wrong. Campaign.
    pub least_misfit: f64,
    /// The same of the level where the noise is estimated from the data. Campaign.
    pub least_misfit_estimated: f64,
    /// Mean of residuals over a part of a run (σ) below which nothing is reported as wrong.
    /// Campaign.
    pub least_mean: f64,
    /// The same in terms of the error of the model. `MuJoCo`.
    pub least_mean_of_model_error: f64,
    /// Factor on the threshold where the noise is estimated from the data. Campaign.
    pub estimated_noise_factor: f64,
    /// Factor on the greatest statistic that was drawn, as the level is finer than the draws.
    /// Campaign.
    pub beyond_draws: f64,
    /// Sets of noise that are drawn at least. Chosen.
    pub least_draws: usize,
    /// Robust standard deviation (σ) above which a smooth misfit is never the instruments'. Chosen.
    pub gross: f64,
    /// Lag-1 autocorrelation above which residuals count as smooth. Chosen.
    pub smooth: f64,
    /// Least number of runs for calling a residual pattern repeatable. Chosen: signs of six runs
    /// agree by chance in 3 % of cases.
    pub repeating_runs: usize,
    /// Part of the residuals' square that must repeat. Real data.
    pub repeating_part: f64,

    // What is known of parameters.
    /// Information of a direction, when each parameter alone has information 1, below which it is
    /// not identifiable: the error of difference quotients.
    pub least_information: f64,
    /// Square of a parameter's part in a unit direction below which it has no part. Chosen.
    pub no_part: f64,
    /// Loss for each reading above which a fit is tried from other starts. Chosen.
    pub poor_fit: f64,
}

/// The policy of every diagnosis.
pub const POLICY: Policy = Policy {
    huber: 3.0,
    noise_as_stated: 1.5,
    correlated_inflation: 2.0,
    noise_disbelieved: 10.0,
    finest_noise: 5e-4,
    repeated_readings: 2.0,
    dither: 0.15,

    unknown_share: 0.2,
    chance_quantile: 0.999,
    least_score: 4.0,
    far_off: 200.0,
    most_fitted: 14,
    score_of_few: 0.03,
    score_of_few_of_many: 0.08,
    many_causes: 3,
    score_of_any: 0.6,
    score_of_apart: 0.1,
    score_of_threshold: 0.5,
    gain_of_far: 0.3,
    gain_at_bound: 0.9,
    most_compared: 4,
    behind_part: 0.02,
    behind_part_correlated: 0.5,
    share_correlated: 0.2,
    far_better: 0.5,
    least_part_held_out: 0.01,
    lasting_readings: 5,

    pair_gain: 60.0,
    pair_part: 0.3,
    pairs_fitted: 6,
    pairs_compared: 3,

    rival_loss: 4.0,
    most_rivals: 2,
    rival_part_correlated: 0.5,
    equal_gain: 1e-3,
    contradiction: 5.0,
    unlimited: 2.0,
    told_apart: 5.0,

    form_error: 0.03,
    form_error_of_one_run: 0.5,
    explained: 0.8,
    least_misfit: 0.03,
    least_misfit_estimated: 0.5,
    least_mean: 0.75,
    least_mean_of_model_error: 4.0,
    estimated_noise_factor: 3.0,
    beyond_draws: 1.25,
    least_draws: 100,
    gross: 5.0,
    smooth: 0.5,
    repeating_runs: 6,
    repeating_part: 0.2,

    least_information: 1e-6,
    no_part: 0.01,
    poor_fit: 1.5,
};
