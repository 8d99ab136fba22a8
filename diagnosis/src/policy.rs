//! The numbers by which a diagnosis decides, in one place, each with what set it.
//!
//! *Chosen*: by the argument that is given, not from data. *Campaign*: set while the synthetic sets
//! of the test laboratory were diagnosed, with other seeds than those of docs/diagnosis.md.
//! *`MuJoCo`*: set while jumps of an independent simulator were diagnosed, with and without a
//! hidden effect. *Real data*: set on the measurements of docs/diagnosis.md. The history of the
//! repository tells the sort of data only, not the sets. Constants of numerical methods (steps of a
//! fit, of a difference quotient) stand beside the methods.

macro_rules! policy {
    ($($(#[$doc:meta])+ $name:ident: $kind:ty = $value:expr;)+) => {
        /// The numbers by which a diagnosis decides. σ is the standard deviation of a reading; a
        /// loss is twice a negative log-likelihood.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Policy { $($(#[$doc])+ pub $name: $kind,)+ }

        /// The policy of every diagnosis.
        pub const POLICY: Policy = Policy { $($name: $value,)+ };
    };
}

policy! {
    // Noise.
    /// Residuals beyond so many σ count in proportion to their size (Huber). Chosen: normal noise
    /// has 0.3 % of them.
    huber: f64 = 3.0;
    /// A robust standard deviation up to so many times the stated one is taken as the stated one.
    /// Real data, whose instruments drift.
    noise_as_stated: f64 = 1.5;
    /// Variance inflation above which residuals count as correlated: runs are then compared, not
    /// readings. Real data.
    correlated_inflation: f64 = 2.0;
    /// A stated noise so many times the observed one is not used. Chosen: a filter of the
    /// instrument and the wish to be on the safe side explain a smaller factor.
    noise_disbelieved: f64 = 10.0;
    /// Least noise of a column, as a part of its range. Chosen: models of machines are not better.
    finest_noise: f64 = 5e-4;
    /// Equal readings of a quantised column, one after the other, count as this many. Campaign.
    repeated_readings: f64 = 2.0;
    /// Noise, in steps of a quantised column, above which each reading has a rounding error of
    /// its own. Campaign.
    dither: f64 = 0.15;

    // Screen and add.
    /// Part of the false-alarm rate that goes to effects without a name. Chosen.
    unknown_share: f64 = 0.2;
    /// Probability below which the χ² of one more cause counts as chance. Chosen: 0.1 %.
    chance_quantile: f64 = 0.999;
    /// Gain in the score test below which no fit is made. Chosen: 2 σ of one parameter. This and
    /// the next five save fits; the score test itself does not depend on them.
    least_score: f64 = 4.0;
    /// Robust standard deviation of the residuals of a channel (σ) above which all causes are
    /// fitted, as scores rest on slopes. Real data: of a pendulum without friction that is driven.
    far_off: f64 = 200.0;
    /// So many causes with the greatest scores are fitted. Chosen.
    most_fitted: usize = 14;
    /// Part of the best score that a cause of these must reach. Chosen.
    score_of_few: f64 = 0.03;
    /// The same beside others where more than `many_causes` may be at work. Chosen, to save time.
    score_of_few_of_many: f64 = 0.08;
    /// See `score_of_few_of_many`.
    many_causes: usize = 3;
    /// Part of the best score from which on a cause is fitted whatever its rank. Chosen.
    score_of_any: f64 = 0.6;
    /// The same of a cause that cannot be reached in small steps, where the score is rough. Chosen.
    score_of_apart: f64 = 0.1;
    /// Part of the threshold that some score must reach for another cause to be sought. Chosen: a
    /// score may be half of the gain of the fit.
    score_of_threshold: f64 = 0.5;
    /// Part of the best gain below which the fit of a cause with many starts is given up. Chosen,
    /// to save time.
    gain_of_far: f64 = 0.3;
    /// Part of the best gain from which on a cause at a bound makes the search start again over
    /// whole ranges. Campaign: a slide that dry friction holds, 199 and 200 N.
    gain_at_bound: f64 = 0.9;
    /// Candidates that are compared on data left out. Chosen.
    most_compared: usize = 4;
    /// Part of the first candidate's gain by which these may be behind (`rival_loss` at least).
    /// Chosen.
    behind_part: f64 = 0.02;
    /// The same where residuals are correlated, and a gain tells less. Real data.
    behind_part_correlated: f64 = 0.5;
    /// Where residuals are correlated, the part of the misfit that each cause must explain. Real
    /// data.
    share_correlated: f64 = 0.2;
    /// Part of the loss on data left out below which a model with one more cause shows, run by run,
    /// that what the one before it leaves is no chance. Real data: of a pendulum that is driven.
    far_better: f64 = 0.5;
    /// Where residuals are correlated, the least part of the loss on data left out that one more cause
    /// must take. Real data.
    least_part_held_out: f64 = 0.01;
    /// Readings of a channel over which an effect must last to count as one. `MuJoCo`: an event
    /// that comes one row later changes one reading.
    lasting_readings: usize = 5;

    // Pairs and exchange.
    /// Loss that two causes must explain together where neither does alone. Chosen: far beyond what
    /// the best of some hundred pairs explains by chance.
    pair_gain: f64 = 60.0;
    /// Part of the misfit that they must explain. Campaign: two effects at once.
    pair_part: f64 = 0.3;
    /// Pairs that are fitted in this search. Chosen.
    pairs_fitted: usize = 6;
    /// Pairs that are fitted to replace causes found one by one. Chosen.
    pairs_compared: usize = 3;

    // Rivals.
    /// Difference in loss below which data do not tell two causes apart: a likelihood ratio of 7
    /// to 1. Chosen.
    rival_loss: f64 = 4.0;
    /// Rivals that are named with a cause; the others are less likely. Chosen: an
    /// answer with more names is no answer.
    most_rivals: usize = 2;
    /// Part of the best gain above which losses of left-out data decide about a rival, where
    /// residuals are correlated. Real data.
    rival_part_correlated: f64 = 0.5;
    /// Gains that differ by less than this part (and half a unit) are equal. Chosen.
    equal_gain: f64 = 1e-3;
    /// Standard deviations from what is known beyond which a cause contradicts it. Chosen: once in
    /// two million times by chance.
    contradiction: f64 = 5.0;
    /// A parameter is unlimited if its bound is farther than so many times the least that explains
    /// the data. Chosen.
    unlimited: f64 = 2.0;
    /// σ of a reading by which two predictions are told apart for sure. Chosen.
    told_apart: f64 = 5.0;

    // Unknown.
    /// Part of the misfit that may remain because the true law differs slightly in shape from the
    /// modelled one. Real data.
    form_error: f64 = 0.03;
    /// The same of a single run, where it cannot be seen what repeats. Chosen.
    form_error_of_one_run: f64 = 0.5;
    /// Part of the misfit that causes must explain where something is left beside them. Chosen.
    explained: f64 = 0.8;
    /// Mean square of residuals beyond 1, or of their smooth part (σ²), below which nothing is
    /// reported as wrong. Campaign.
    least_misfit: f64 = 0.03;
    /// The same of the level where the noise is estimated from the data. Campaign.
    least_misfit_estimated: f64 = 0.5;
    /// Mean of residuals over a part of a run (σ) below which nothing is reported as wrong.
    /// Campaign.
    least_mean: f64 = 0.75;
    /// The same in terms of the error of the model. `MuJoCo`.
    least_mean_of_model_error: f64 = 4.0;
    /// Factor on the threshold where the noise is estimated from the data. Campaign.
    estimated_noise_factor: f64 = 3.0;
    /// Factor on the greatest statistic that was drawn, as the level is finer than the draws.
    /// Campaign.
    beyond_draws: f64 = 1.25;
    /// Sets of noise that are drawn at least. Chosen.
    least_draws: usize = 100;
    /// Robust standard deviation (σ) above which a smooth misfit is never the instruments'. Chosen.
    gross: f64 = 5.0;
    /// Lag-1 autocorrelation above which residuals count as smooth. Chosen.
    smooth: f64 = 0.5;
    /// Least number of runs for calling a residual pattern repeatable. Chosen: signs of six runs
    /// agree by chance in 3 % of cases.
    repeating_runs: usize = 6;
    /// Part of the residuals' square that must repeat. Real data.
    repeating_part: f64 = 0.2;

    // What is known of parameters.
    /// Information of a direction, when each parameter alone has information 1, below which it is
    /// not identifiable: the error of difference quotients.
    least_information: f64 = 1e-6;
    /// Square of a parameter's part in a unit direction below which it has no part. Chosen.
    no_part: f64 = 0.01;
    /// Loss for each reading above which a fit is tried from other starts. Chosen.
    poor_fit: f64 = 1.5;
}
