"""Which tolerance matters: inputs spread about their values, and the shares of the outputs' variance that they cause.

Every input is uniform within its half-width about its value, independent of the others: an interval in which a dimension is
accepted, or in which a printed number was rounded. Two samples A and B of a scrambled Sobol sequence, and A with the columns
of B one at a time, give Saltelli's estimate of the first-order index V(E(y|x_i))/V(y), the share of the variance that would
vanish if x_i were known, and of the total index E(V(y|all but x_i))/V(y), the share that x_i has a part in
(``scipy.stats.sobol_indices``). For small spreads the standard deviation is that of first-order error propagation,
sqrt(sum (dy/dx_i sigma_i)^2).
"""
