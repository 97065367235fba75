/* As a library does that was built with -ffast-math: numbers below the normal ones become 0 in the thread that loads it;
 * and rounds upwards. LD_PRELOAD=libfloating_point.so program ... */
#include <fenv.h>

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

__attribute__((constructor)) static void change(void) {
  fesetround(FE_UPWARD);
#if defined(__x86_64__)
  _mm_setcsr(_mm_getcsr() | 0x8040); /* flush to zero, denormals are zero */
#endif
}
