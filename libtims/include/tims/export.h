/* What libtims.so shows to other programs; all else stays inside. */
#ifndef TIMS_EXPORT_H
#define TIMS_EXPORT_H

#define TIMS_API __attribute__((visibility("default")))

#endif
