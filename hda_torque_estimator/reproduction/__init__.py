"""The paper's figures and tables, made again by the simulator, estimator and controller."""
