/* How Unity is built here. A test source is one part of a program: its main, setUp and tearDown carry the name of the
 * source. */
#ifndef UNITY_CONFIG_H
#define UNITY_CONFIG_H

#define UNITY_INCLUDE_DOUBLE
#define UNITY_SUPPORT_64

#ifdef EMA_TEST_SOURCE
#define EMA_TEST_JOIN_EXPANDED(name, part) name##_##part
#define EMA_TEST_JOIN(name, part) EMA_TEST_JOIN_EXPANDED(name, part)
#define main EMA_TEST_JOIN(EMA_TEST_SOURCE, main)
#define setUp EMA_TEST_JOIN(EMA_TEST_SOURCE, setUp)
#define tearDown EMA_TEST_JOIN(EMA_TEST_SOURCE, tearDown)
int main(void);
#endif

#endif
