"""Names that the JSON of a result leaves out where there is nothing to say."""

# Written by python/generate.py: do not edit.

from __future__ import annotations

LEFT_OUT_LISTS = frozenset(
    [
        "bought", "columns", "cores", "discovered", "errors_after", "errors_before",
        "errors_calibrated", "holdout_errors", "indistinguishable", "latents", "limits", "mistakes",
        "not_measured", "not_required", "notices", "ports_alike", "posterior", "registered",
        "replaced", "warnings",
    ]
)

LEFT_OUT = frozenset(
    [
        "accuracy", "achieved", "agrees", "alike", "amplitude_n", "best_log", "beyond",
        "by_hand_half_share", "category", "cell", "chance", "channel", "channels", "clock",
        "collinearity_rad", "delay_periods", "delay_s", "derivative", "deviation", "distance",
        "draw", "draws_seed", "drift", "envelope_n", "error", "evidence", "evidence_nats",
        "explained", "expression", "factor", "failed", "failure_probability", "fall", "fault",
        "figure", "figures", "filed", "filed_out_of_reach", "first", "first_limit",
        "first_within_5pct_s", "follows", "force_base_n", "force_n", "force_sensor_dies",
        "force_step_n", "frequency_hz", "from", "from_log", "gain", "given", "group", "half_share",
        "held_by_control", "high", "holdout_score", "holdout_score_after", "holdout_score_before",
        "implausible", "informed", "joint", "kept_again", "kind", "label", "largest",
        "lateral_max_m", "lateral_rms_limit_m", "lateral_rms_m", "left", "left_m", "left_out",
        "left_rad", "level", "limit", "log", "longitudinal_max_m", "lost_share", "low", "map",
        "max", "mean", "mean_interval", "measurement", "middle", "modulus", "mountings",
        "needed_ns_m", "next_experiment", "noise", "noise_factor", "numbers", "of_limit",
        "offset_s", "only_in_last_pass", "outliers", "overshoot", "p", "payload_kg", "period_s",
        "phase_rad", "probability", "push_envelope_n", "push_error_rms_n", "rare", "rate_rad_s",
        "reason", "reported_after_s", "rms_after", "rms_before", "rmse", "samples_there", "score",
        "score_after", "score_before", "score_calibrated", "separation", "settle_5pct_s", "share",
        "share_by_chance", "share_there", "side_tilt_rms_rad", "simulation", "spectral_radius",
        "spread", "spread_interval", "standard_deviation", "static_error_n", "stiffness_error",
        "stiffness_nm_rad", "surface", "there_ns_m", "tilt_max_rad", "told_apart_from_limit_times",
        "tracker", "travel_angle_rms_rad", "unit", "used", "usual_n", "value", "weight",
        "worst_of_weld",
    ]
)
