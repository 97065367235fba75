#include "libm.h"

/* musl's also tells the sign of gamma, in a variable that all threads share. */
double lgamma(double x)
{
	int sign;
	return __lgamma_r(x, &sign);
}
